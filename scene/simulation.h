// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/particles.h>
#include <selvedge/scene/output.h>
#include <selvedge/scene/scene.h>

#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge {

/// Everything a simulation carries from one step to the next: restored from it, it goes on to the
/// same bits.
struct SimulationState {
  std::int64_t step = 0;  ///< accepted steps so far
  double time = 0.0;      ///< s
  std::vector<Vec3> x, v;
};

/// The run cannot go on: diverged, or a step that cannot be made clean. Says which particle or
/// pair.
class SimulationFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The cloth of a scene in time. Throws std::invalid_argument from the constructor if the cloth
/// crosses a body or itself at the start (count, first pair, remedy).
class Simulation {
 public:
  Simulation(const Scene& scene, BuiltScene built, const Methods& methods = {});
  ~Simulation();

  /// Advances to the time of frame `frame` (frame / fps). Calls `accepted` after every accepted
  /// step with the state's time; may be empty. Throws SimulationFailed and keeps the last good
  /// state.
  void advance_to_frame(int frame, const std::function<void(double time)>& accepted);

  const SimulationState& state() const;
  /// Goes on from `state` (same scene); throws std::invalid_argument if its size does not fit.
  void restore(SimulationState state);

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
