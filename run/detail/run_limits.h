// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/run/run.h>
#include <selvedge/simulation/simulation_state.h>

#include <cstdint>

namespace selvedge::detail {

/// Stops a run that is out of budget or stalled (RunConfig).
class RunLimits {
 public:
  /// Scene and config must outlive it. `first_step`: steps accepted before this run.
  RunLimits(const Scene& scene, const RunConfig& config, std::int64_t first_step)
      : scene_(scene), config_(config), first_step_(first_step) {}

  /// Before a step. `wall_s`: wall seconds since the start of the run. Throws SimulationFailed when
  /// the budget is used up.
  void before_step(const Simulation& simulation, double wall_s);
  /// After an accepted step. Throws SimulationFailed for a stalled run; then the simulation is in
  /// the state before that step, so that its replay shows the cause.
  void after_step(Simulation& simulation);

 private:
  void check_budget(const SimulationState& state, double wall_s) const;
  [[noreturn]] void stall(Simulation& simulation);

  const Scene& scene_;
  const RunConfig& config_;
  std::int64_t first_step_;
  int halvings_ = 0;              // before the step
  int small_steps_ = 0;           // accepted in a row near the smallest step length
  SimulationState before_stall_;  // before the step that may complete a stall
};

}  // namespace selvedge::detail
