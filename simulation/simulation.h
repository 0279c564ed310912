// SPDX-License-Identifier: MIT
//
// The cloth of a scene in time. Beside it: simulation_state.h (what a checkpoint keeps),
// step_report.h (attempts and contacts of the last step), run_result.h (counts of all steps).
#pragma once

#include <selvedge/core/base/types.h>
#include <selvedge/simulation/failure.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

class CarriedSimulation;
class DrivenBody;    // bodies/driven_body.h
class VertexNames;   // run_result.h
struct BuiltScene;   // scene/build.h
struct FinalState;   // simulation_state.h
struct Methods;      // scene/methods.h
struct PassedState;  // simulation_state.h
struct RestReport;
struct RunResult;
struct Scene;  // scene/scene.h
struct SimulationState;
struct StepContact;  // step_report.h
struct StepReport;
struct StepWrenches;
struct StepTrace;  // explain_step.h

/// Replaces a body of a built scene by one at the same place whose vertices the program sets; the
/// simulation that is made of the scene owns it. Throws std::invalid_argument for a missing body.
DrivenBody& drive_body(BuiltScene& built, std::size_t body);

/// The cloth of a scene in time, in memory. Spans are valid until the mesh changes, which it does
/// at frames if the scene has "refine" or "merge"; `owner` keeps them longer.
class Simulation {
 public:
  /// Throws std::invalid_argument for a scene that cannot be built, and for cloth that crosses a
  /// body or itself at the start, unless the scene untangles it.
  explicit Simulation(const Scene& scene);
  Simulation(const Scene& scene, const Methods& methods);
  Simulation(const Scene& scene, BuiltScene built);
  Simulation(const Scene& scene, BuiltScene built, const Methods& methods);
  /// Continues from a state, as `restore` does; the start of the scene is not checked. A state
  /// without memory starts with that of the integrator and the forces at the start.
  Simulation(const Scene& scene, BuiltScene built, SimulationState state);
  Simulation(const Scene& scene, BuiltScene built, SimulationState state, const Methods& methods);
  ~Simulation();

  /// Makes one accepted step: a nominal step of 1 / (fps · steps_per_frame) s, the next part of one
  /// that had to be halved, or the change of the mesh that is due at a frame. While the cloth
  /// sleeps, the time alone advances. Throws SimulationFailed and keeps the last good state.
  void step();
  /// The same towards frame `frame`; returns false, without a step, if its time is reached.
  bool step_towards(int frame);
  /// Advances to the time of frame `frame`, frame / fps, and verifies each frame. Calls `accepted`,
  /// which may be empty, with the time after every step.
  void advance_to_frame(int frame, const std::function<void(double time)>& accepted = {});
  /// Searches the state for crossings, unless its steps prove that there are none, and counts them.
  void verify_frame();
  bool reached(int frame) const;
  int frame() const;         ///< the last one whose time is reached
  bool is_at_frame() const;  ///< no step has been made since `frame()`

  // Inputs act until they are set again, and `restore` forgets them. The functions throw
  // std::invalid_argument for a wrong length or index, a value that is not finite, and a mesh that
  // may change.
  double nominal_end() const;  ///< s, of the nominal step that comes next or is under way
  /// N, on the cloth vertices, constant during each step, beside the scene's. Empty: none.
  void set_forces(std::span<const Vec3> forces);
  /// Moves these vertices on straight lines to x[k] (m) by `nominal_end`, and holds them there.
  void hold(std::span<const std::int32_t> vertices, std::span<const Vec3> x);
  void release(std::span<const std::int32_t> vertices);
  void release_all();
  /// Moves a driven body: each vertex on a straight line to x[i] (m) by `nominal_end`.
  void move_body(DrivenBody& body, std::span<const Vec3> x);

  double time() const;                       ///< s
  std::span<const Vec3> positions() const;   ///< m, of the cloth vertices, as the next three
  std::span<const Vec3> velocities() const;  ///< m/s
  const std::vector<double>& mass() const;   ///< kg, water included
  std::vector<std::uint8_t> flags() const;   ///< bits of VertexFlag
  std::span<const Triangle> cloth_triangles() const;
  std::span<const Triangle> body_triangles() const;  ///< of all bodies, joined in scene order
  const std::vector<Vec3>& body_positions() const;   ///< m, at the state's time
  bool bodies_move() const;                          ///< at any time before the last frame
  const BuiltScene& built() const;                   ///< with the present vertices at the start
  const VertexNames& names() const;
  std::shared_ptr<const void> owner() const;
  std::map<std::string, double> energies() const;  ///< J, by the names of selvedge::energies

  /// Of the last accepted step, with the impulses of the response but not of the fail-safe. Empty
  /// before the first step, after `restore`, a change of the mesh, and a step that failed.
  std::vector<StepContact> contacts() const;
  const StepReport& last_step() const;
  /// Whether steps from now on measure what bodies, handles and held particles feel. A scene with
  /// output.wrenches does.
  void measure_wrenches(bool on);
  bool measures_wrenches() const;
  /// Of the last accepted step since then, and the mean of the steps since the last frame was
  /// reached. Both throw std::logic_error unless wrenches are measured.
  const StepWrenches& wrenches() const;
  StepWrenches frame_wrenches() const;
  void set_trace(const StepTrace* trace);  ///< of every attempt; null: none
  /// Whether the cloth is in equilibrium now: takes as long as a part of a step.
  RestReport rest();
  /// The same without the report, which it computes only where the cloth is slow enough.
  bool is_at_rest();
  /// Since the start. The caller fills frames, wall_s, peak_bytes, stopped and rest.
  RunResult result() const;

  const SimulationState& state() const;
  /// The states that the last step passed through before its last one, in order: cells were split
  /// and others joined in one step, or nodes went straight to the surface on which cells are
  /// joined.
  std::span<const PassedState> passed() const;
  /// Continues from a state of the scene. Throws std::invalid_argument for one of another size.
  void restore(SimulationState state);
  /// The same in another run, whose result until then was `before`.
  void resume(SimulationState state, RunResult before);
  FinalState end() &&;  ///< frees most of the memory

 private:
  friend class CarriedSimulation;  // internal/carried.h
  struct Carried;
  struct Parts;        // of the simulation with the present mesh
  struct MeshChanges;  // null: the mesh stays
  bool change_mesh();
  bool is_of_present_mesh(const SimulationState& state) const;
  void refuse_changing_mesh() const;

  std::shared_ptr<Parts> parts_;
  std::unique_ptr<MeshChanges> changes_;
};

}  // namespace selvedge
