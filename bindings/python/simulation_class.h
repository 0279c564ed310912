// SPDX-License-Identifier: MIT
//
// The methods that Python has of a simulation: of one alone, and of a member of a batch.
#pragma once

#include <pybind11/stl.h>
#include <selvedge/bindings/c/driven_simulation.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/simulation/step_report.h>

#include <string>
#include <vector>

#include "arrays.h"
#include "interruptible.h"

namespace selvedge::python {

/// Calls use(simulation) without the lock of the interpreter.
template <class Session, class Use>
auto unlocked(Session& session, Use use) {
  const OneThread mine(session.busy(), Session::kName);
  const py::gil_scoped_release release;
  return use(session.now());
}

template <class Session>
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

inline std::span<const std::int32_t> list_of(const Whole& vertices) {
  return {vertices.data(), static_cast<std::size_t>(vertices.size())};
}

inline py::tuple wrench_arrays(const std::vector<Wrench>& list, const Vec3& about) {
  return py::make_tuple(
      column<double>(list, [](const Wrench& w) { return w.force; }),
      column<double>(list, [&](const Wrench& w) { return w.torque_about(about); }));
}

inline py::array vector_of(const Vec3& v) {
  return own<double>(std::vector<double>(v.begin(), v.end()));
}

inline py::tuple mass_arrays(const std::vector<EffectiveMass>& list) {
  std::vector<double> mass;
  py::array_t<double> inertia({py::ssize_t(list.size()), py::ssize_t(3), py::ssize_t(3)});
  for (std::size_t b = 0; b < list.size(); ++b) {
    mass.push_back(list[b].mass);
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) inertia.mutable_at(b, i, k) = list[b].inertia(i, k);
  }
  return py::make_tuple(own<double>(std::move(mass)),
                        column<double>(list, [](const EffectiveMass& m) { return m.centre; }),
                        inertia);
}

template <class S>
py::dict wrench_table(S& session, bool mean, const Vec3& about) {
  const StepWrenches found = unlocked(
      session, [&](Simulation& now) { return mean ? now.frame_wrenches() : now.wrenches(); });
  py::dict out, others;
  out["h"] = found.h;
  out["bodies"] = wrench_arrays(found.bodies, about);
  out["solids"] = wrench_arrays(found.solids, about);
  out["body_mass"] = mass_arrays(found.body_mass);
  out["handles"] = wrench_arrays(found.handles, about);
  out["held"] = own<std::int32_t>(std::vector<std::int32_t>(found.held));
  out["held_force"] = column<double>(found.held_force, [](const Vec3& f) { return f; });
  for (const auto& [name, w] : found.others)
    others[name.c_str()] = py::make_tuple(vector_of(w.force), vector_of(w.torque_about(about)));
  out["others"] = others;
  out["change"] =
      py::make_tuple(vector_of(found.change.force), vector_of(found.change.torque_about(about)));
  out["force_error"] = found.force_error;
  out["torque_error"] = found.torque_error;
  return out;
}

template <class S, class... Rest>
void define_steps(py::class_<S, Rest...>& c) {
  c.def("step", [](S& s) { unlocked(s, [](Simulation& now) { now.step(); }); })
      .def("step_towards",
           [](S& s, int frame) {
             return unlocked(s, [&](Simulation& now) { return now.step_towards(frame); });
           })
      .def("verify_frame", [](S& s) { unlocked(s, [](Simulation& now) { now.verify_frame(); }); })
      .def("reached", [](S& s, int frame) { return s.now().reached(frame); })
      .def_property_readonly("frame", [](S& s) { return s.now().frame(); })
      .def("set_forces",
           [](S& s, const Doubles& f) {
             unlocked(s, [&](Simulation& now) { now.set_forces(positions(f, "forces")); });
           })
      .def("hold",
           [](S& s, const Whole& vertices, const Doubles& x) {
             unlocked(s, [&](Simulation& now) { now.hold(list_of(vertices), positions(x, "x")); });
           })
      .def("release",
           [](S& s, const Whole& vertices) {
             unlocked(s, [&](Simulation& now) { now.release(list_of(vertices)); });
           })
      .def("release_all", [](S& s) { unlocked(s, [](Simulation& now) { now.release_all(); }); })
      .def("move_body",
           [](S& s, std::size_t body, const Doubles& x) {
             unlocked(s, [&](Simulation&) { s.move_body(body, positions(x, "x")); });
           })
      .def("save", [](S& s) { return unlocked(s, [&](Simulation&) { return s.save(); }); })
      .def("restore", [](S& s, const MemberState& saved) {
        unlocked(s, [&](Simulation&) { s.restore(saved); });
      });
}

template <class S, class... Rest>
void define_reading(py::class_<S, Rest...>& c) {
  c.def_property_readonly("time", [](S& s) { return s.now().time(); })
      .def_property_readonly("steps", [](S& s) { return s.now().state().step; })
      .def_property_readonly("nominal_end", [](S& s) { return s.now().nominal_end(); })
      .def_property_readonly("last_step",
                             [](S& s) {
                               const auto& lengths = s.now().last_step().lengths;
                               return lengths.empty() ? 0.0 : lengths.back();
                             })
      .def_property_readonly("state_hash", [](S& s) { return state_hash(s.now().state()); })
      .def_property_readonly("positions",
                             [](S& s) { return view<double>(s.positions(), s.owner()); })
      .def_property_readonly("velocities",
                             [](S& s) { return view<double>(s.velocities(), s.owner()); })
      .def_property_readonly("mass", [](S& s) { return s.mass(); })
      .def_property_readonly(
          "triangles",
          [](S& s) { return view<std::int32_t>(s.now().cloth_triangles(), s.now().owner()); })
      .def_property_readonly("body_positions", [](S& s) { return s.body_positions(); })
      .def_property_readonly(
          "body_triangles",
          [](S& s) { return view<std::int32_t>(s.now().body_triangles(), s.now().owner()); })
      .def_property_readonly("piece_begin", [](S& s) { return s.now().built().piece_begin; })
      .def_property_readonly("body_begin", [](S& s) { return s.body_begin(); })
      .def_property_readonly(
          "vertex_areas",
          [](S& s) {
            return own<double>(vertex_areas(s.now().positions(), s.now().cloth_triangles()));
          })
      .def("flags",
           [](S& s) {
             return own<std::uint8_t>(unlocked(s, [](Simulation& now) { return now.flags(); }));
           })
      .def("contacts", &contact_table<S>)
      .def("measure_wrenches",
           [](S& s, bool on) { unlocked(s, [&](Simulation& now) { now.measure_wrenches(on); }); })
      .def("wrenches",
           [](S& s, bool mean, const std::array<double, 3>& about) {
             return wrench_table(s, mean, Vec3(about[0], about[1], about[2]));
           })
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
      .def_property_readonly("warnings", [](S& s) { return s.now().built().warnings; });
}

}  // namespace selvedge::python
