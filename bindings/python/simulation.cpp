// SPDX-License-Identifier: MIT
//
// Scenes, and simulations in memory.
#include <pybind11/stl.h>
#include <selvedge/bindings/c/driven_simulation.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/internal/scene_text.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/simulation/step_report.h>

#include "arrays.h"
#include "interruptible.h"
#include "parts.h"

namespace selvedge::python {
namespace {

using SharedScene = std::shared_ptr<const Scene>;

using bindings::SavedState;
using Session = bindings::DrivenSimulation;

/// Calls use(simulation) without the lock of the interpreter.
template <class Use>
auto unlocked(Session& session, Use use) {
  const OneThread mine(session.busy(), "simulation");
  const py::gil_scoped_release release;
  return use(session.now());
}

py::dict contact_table(Session& session) {
  const std::vector<StepContact> found =
      unlocked(session, [](Simulation& s) { return s.contacts(); });
  using C = StepContact;
  py::dict out;
  out["kind"] = column<std::uint8_t>(
      found, [](const C& c) { return static_cast<std::uint8_t>(c.point.kind); });
  out["vertices"] = column<std::int32_t>(found, [](const C& c) { return c.point.vertex; });
  out["weights"] = column<double>(found, [](const C& c) { return c.point.weight; });
  out["normal"] = column<double>(found, [](const C& c) { return c.point.normal; });
  out["gap"] = column<double>(found, [](const C& c) { return c.gap; });
  out["rest_gap"] = column<double>(found, [](const C& c) { return c.point.rest_gap; });
  out["impulse"] = column<double>(found, [](const C& c) { return c.impulse; });
  return out;
}

template <class Named>
std::vector<std::string> names_of(const std::vector<Named>& list) {
  std::vector<std::string> names;
  for (const Named& entry : list) names.push_back(entry.name);
  return names;
}

py::array vector_of(const Vec3& v) { return own<double>(std::vector<double>(v.begin(), v.end())); }

}  // namespace

void add_scene(py::module_& m, const SharedMethods& methods) {
  const auto overrides = [](const std::vector<std::pair<std::string, std::string>>& given) {
    std::vector<Override> out;
    for (const auto& [path, value] : given) out.push_back({path, value});
    return out;
  };
  using Given = std::vector<std::pair<std::string, std::string>>;
  py::class_<Scene, std::shared_ptr<Scene>>(m, "Scene")
      .def_static("from_file",
                  [=](const std::string& file, const Given& set) {
                    return std::make_shared<Scene>(read_scene(file, overrides(set), *methods));
                  })
      .def_static(
          "from_text",
          [=](const std::string& text, const std::string& file, const Given& set) {
            return std::make_shared<Scene>(read_scene_text(text, file, overrides(set), *methods));
          })
      .def_readonly("name", &Scene::name)
      .def_readonly("json", &Scene::json)
      .def_property_readonly("frames", [](const Scene& s) { return s.time.frames; })
      .def_property_readonly("fps", [](const Scene& s) { return s.time.fps; })
      .def_property_readonly("steps_per_frame",
                             [](const Scene& s) { return s.time.steps_per_frame; })
      .def_property_readonly("gravity", [](const Scene& s) { return vector_of(s.gravity); })
      .def_property_readonly("cloths", [](const Scene& s) { return names_of(s.cloths); })
      .def_property_readonly("bodies", [](const Scene& s) { return names_of(s.bodies); });
}

void add_simulation(py::module_& m, const SharedMethods& methods) {
  static py::exception<SimulationFailed> failed(m, "SimulationFailed", PyExc_RuntimeError);
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const SimulationFailed& error) {
      py::object value = failed.attr("__call__")(error.what());
      value.attr("kind") = failure_name(error.kind);
      PyErr_SetObject(failed.ptr(), value.ptr());
    }
  });
  py::class_<SavedState>(m, "SavedState").def_property_readonly("time", [](const SavedState& s) {
    return s.state.time;
  });
  using S = Session;
  py::class_<S>(m, "Simulation")
      .def(
          py::init([methods](std::shared_ptr<Scene> scene, const std::vector<std::size_t>& driven) {
            const py::gil_scoped_release release;
            return std::make_unique<S>(std::move(scene), methods, std::span(driven));
          }))
      .def("step", [](S& s) { unlocked(s, [](Simulation& now) { now.step(); }); })
      .def("step_towards",
           [](S& s, int frame) {
             return unlocked(s, [&](Simulation& now) { return now.step_towards(frame); });
           })
      .def("verify_frame", [](S& s) { unlocked(s, [](Simulation& now) { now.verify_frame(); }); })
      .def("reached", [](const S& s, int frame) { return s.now().reached(frame); })
      .def("set_forces",
           [](S& s, const Doubles& f) {
             unlocked(s, [&](Simulation& now) { now.set_forces(positions(f, "forces")); });
           })
      .def("hold",
           [](S& s, const Whole& vertices, const Doubles& x) {
             const std::span<const std::int32_t> list(vertices.data(),
                                                      static_cast<std::size_t>(vertices.size()));
             unlocked(s, [&](Simulation& now) { now.hold(list, positions(x, "x")); });
           })
      .def("release",
           [](S& s, const Whole& vertices) {
             const std::span<const std::int32_t> list(vertices.data(),
                                                      static_cast<std::size_t>(vertices.size()));
             unlocked(s, [&](Simulation& now) { now.release(list); });
           })
      .def("release_all", [](S& s) { unlocked(s, [](Simulation& now) { now.release_all(); }); })
      .def("move_body",
           [](S& s, std::size_t body, const Doubles& x) {
             unlocked(s, [&](Simulation&) { s.move_body(body, positions(x, "x")); });
           })
      .def("save", [](S& s) { return unlocked(s, [&](Simulation&) { return s.save(); }); })
      .def("restore",
           [](S& s, const SavedState& saved) {
             unlocked(s, [&](Simulation&) { s.restore(saved); });
           })
      .def_property_readonly("time", [](const S& s) { return s.now().time(); })
      .def_property_readonly("steps", [](const S& s) { return s.now().state().step; })
      .def_property_readonly("nominal_end", [](const S& s) { return s.now().nominal_end(); })
      .def_property_readonly("last_step",
                             [](const S& s) {
                               const auto& lengths = s.now().last_step().lengths;
                               return lengths.empty() ? 0.0 : lengths.back();
                             })
      .def_property_readonly("state_hash", [](const S& s) { return state_hash(s.now().state()); })
      .def_property_readonly(
          "positions",
          [](const S& s) { return view<double>(s.now().positions(), s.now().owner()); })
      .def_property_readonly(
          "velocities",
          [](const S& s) { return view<double>(s.now().velocities(), s.now().owner()); })
      .def_property_readonly("mass",
                             [](const S& s) {
                               return view<double>(std::span<const double>(s.now().mass()),
                                                   s.now().owner());
                             })
      .def_property_readonly(
          "triangles",
          [](const S& s) { return view<std::int32_t>(s.now().cloth_triangles(), s.now().owner()); })
      .def_property_readonly("body_positions",
                             [](const S& s) {
                               return view<double>(std::span<const Vec3>(s.now().body_positions()),
                                                   s.now().owner());
                             })
      .def_property_readonly(
          "body_triangles",
          [](const S& s) { return view<std::int32_t>(s.now().body_triangles(), s.now().owner()); })
      .def_property_readonly("piece_begin", [](const S& s) { return s.now().built().piece_begin; })
      .def_property_readonly("body_begin", &S::body_begin)
      .def_property_readonly(
          "vertex_areas",
          [](const S& s) {
            return own<double>(vertex_areas(s.now().positions(), s.now().cloth_triangles()));
          })
      .def("flags",
           [](S& s) {
             return own<std::uint8_t>(unlocked(s, [](Simulation& now) { return now.flags(); }));
           })
      .def("contacts", &contact_table)
      .def("energies",
           [](S& s) { return unlocked(s, [](Simulation& now) { return now.energies(); }); })
      .def("result_text",
           [](S& s) {
             return result_text(unlocked(s, [](Simulation& now) {
               RunResult result = now.result();
               result.rest = now.rest();
               return result;
             }));
           })
      .def_property_readonly("warnings", &S::warnings);
  std::vector<std::string> flags;
  for (int bit = 0; bit < kVertexFlags; ++bit) flags.emplace_back(flag_name(bit));
  m.attr("flag_names") = flags;
}

}  // namespace selvedge::python
