// SPDX-License-Identifier: MIT
//
// Scenes, and simulations in memory.
#include <selvedge/run/internal/state_text.h>
#include <selvedge/scene/internal/scene_text.h>

#include "parts.h"
#include "simulation_class.h"

namespace selvedge::python {
namespace {

/// A simulation alone. Its arrays view its own memory.
class Session : public bindings::DrivenSimulation {
 public:
  static constexpr const char* kName = "simulation";
  using DrivenSimulation::DrivenSimulation;

  std::span<const Vec3> positions() const { return now().positions(); }
  std::span<const Vec3> velocities() const { return now().velocities(); }
  std::shared_ptr<const void> owner() const { return now().owner(); }
  py::array mass() const { return view<double>(std::span<const double>(now().mass()), owner()); }
  py::array body_positions() const {
    return view<double>(std::span<const Vec3>(now().body_positions()), owner());
  }
};

template <class Named>
std::vector<std::string> names_of(const std::vector<Named>& list) {
  std::vector<std::string> names;
  for (const Named& entry : list) names.push_back(entry.name);
  return names;
}

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
  py::class_<MemberState>(m, "SavedState")
      .def_static("from_text",
                  [](const std::string& text) {
                    auto [state, bodies] = state_from_text(text);
                    return MemberState{std::move(state), std::move(bodies)};
                  })
      .def("text", [](const MemberState& s) { return state_text(s.state, s.bodies); })
      .def_property_readonly("time", [](const MemberState& s) { return s.state.time; });
  py::class_<Session> simulation(m, "Simulation");
  simulation.def(
      py::init([methods](std::shared_ptr<Scene> scene, const std::vector<std::size_t>& driven) {
        const py::gil_scoped_release release;
        return std::make_unique<Session>(std::move(scene), methods, std::span(driven));
      }));
  define_steps(simulation);
  define_reading(simulation);
  std::vector<std::string> flags;
  for (int bit = 0; bit < kVertexFlags; ++bit) flags.emplace_back(flag_name(bit));
  m.attr("flag_names") = flags;
}

}  // namespace selvedge::python
