// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/particles.h>
#include <selvedge/scene/excluded_pairs.h>
#include <selvedge/scene/output.h>
#include <selvedge/scene/scene.h>
#include <selvedge/scene/step_failure.h>
#include <selvedge/scene/step_trace.h>
#include <selvedge/scene/vertex_names.h>

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// Where a simulation stands between the ends of two nominal steps.
struct StepControl {
  std::int64_t done = 0;  ///< nominal steps that are complete; counts only where h > 0
  double h = 0.0;         ///< s, length of the next try; 0: at the end of a nominal step
  int halvings = 0;       ///< how often the nominal step was halved to get it
};

/// Everything a simulation carries from one step to the next: restored from it, it goes on to the
/// same bits.
struct SimulationState {
  std::int64_t step = 0;  ///< accepted steps so far
  double time = 0.0;      ///< s
  std::vector<Vec3> x, v;
  std::vector<double> water;  ///< kg per vertex; empty where the scene has none
  StepControl control;
  std::vector<double> memory;      ///< of the integrator and the forces, as they save it
  Tangles tangles;                 ///< crossings of the start that are still being undone
  std::vector<SplitEvent> splits;  ///< how the present cells of refined pieces came about
};

/// The cloth of a scene in time. Throws std::invalid_argument from the constructor if the cloth
/// crosses a body or itself at the start (count, first pair, remedy) and is not to be untangled.
class Simulation {
 public:
  Simulation(const Scene& scene, BuiltScene built, const Methods& methods = {});
  ~Simulation();

  /// Advances to the time of frame `frame` (frame / fps). Calls `accepted` after every accepted
  /// step with the state's time; may be empty. Throws SimulationFailed and keeps the last good
  /// state.
  void advance_to_frame(int frame, const std::function<void(double time)>& accepted);

  /// Makes one accepted step on the way to frame `frame`; false, and nothing done, if its time is
  /// reached. Throws SimulationFailed and keeps the last good state.
  bool step_towards(int frame);

  /// Whether the time of frame `frame` is reached.
  bool reached(int frame) const;
  /// Looks for crossings in the present state, which the result then tells of.
  void verify_frame();

  const SimulationState& state() const;
  /// Goes on from `state` (same scene); throws std::invalid_argument if its size does not fit.
  void restore(SimulationState state);

  /// Lengths of the tries of the last step, s, the accepted one included.
  const std::vector<double>& tried() const;
  /// The last try that did not come out clean, of any step so far.
  const FailedTry& failed_try() const;
  const VertexNames& names() const;
  /// Tells `trace` of every try from now on; it must outlive them. Null: nobody.
  void set_trace(const StepTrace* trace);

  /// What is not guaranteed of each cloth vertex in the present state (vertex_flags.h).
  std::vector<std::uint8_t> flags() const;

  const BuiltScene& built() const;
  const std::vector<double>& mass() const;  ///< kg per cloth vertex, water included
  std::span<const Triangle> cloth_triangles() const;
  std::span<const Triangle> body_triangles() const;  ///< of all bodies, joined in scene order
  const std::vector<Vec3>& body_positions() const;   ///< at the state's time
  bool bodies_move() const;

  /// Clean, steps, halvings, strain, speed, phase times and counters so far; frames, wall_s,
  /// peak_bytes and stopped are the caller's.
  RunResult result() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// FNV-1a over the bytes of positions and velocities, as 16 hex digits.
std::string state_hash(const SimulationState& state);

}  // namespace selvedge
