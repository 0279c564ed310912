// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/run/detail/run_limits.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/simulation/step_report.h>

#include <string>
#include <utility>

namespace selvedge::detail {

void RunLimits::before_step(const Simulation& simulation, double wall_s) {
  const SimulationState& state = simulation.state();
  check_budget(state, wall_s);
  halvings_ = state.control.halvings;
  if (small_steps_ + 1 == config_.stall_steps) before_stall_ = state;
}

void RunLimits::after_step(Simulation& simulation) {
  const int attempts = static_cast<int>(simulation.last_step().lengths.size());
  if (attempts == 0) return;  // a change of the mesh
  const bool small = is_near_smallest(halvings_ + attempts - 1, scene_.time.max_halvings);
  small_steps_ = small ? small_steps_ + 1 : 0;
  if (small && small_steps_ == config_.stall_steps) stall(simulation);
}

void RunLimits::check_budget(const SimulationState& state, double wall_s) const {
  const std::int64_t steps = state.step - first_step_;
  const bool steps_left = config_.max_steps <= 0 || steps < config_.max_steps;
  if (steps == 0 || (wall_s <= config_.budget_s && steps_left)) return;
  const std::string budget = steps_left ? fmt::format("{} s of wall time", config_.budget_s)
                                        : fmt::format("{} accepted steps", config_.max_steps);
  throw SimulationFailed(FailureKind::out_of_budget,
                         fmt::format("out of budget at {} s of {} s: the budget was {}", state.time,
                                     scene_.time.frames / scene_.time.fps, budget));
}

void RunLimits::stall(Simulation& simulation) {
  simulation.restore(std::move(before_stall_));
  const RejectedAttempt& failed = simulation.last_step().rejected;
  std::string cause = fmt::format(
      "stalled at {} s: each of the last {} steps was accepted only after {} or more halvings, the "
      "last one with {} s; before that: {}",
      simulation.state().time, config_.stall_steps, scene_.time.max_halvings - 1,
      simulation.last_step().lengths.back(), failed.cause);
  if (!failed.pairs.empty()) cause += ", first " + simulation.names().pair(failed.pairs[0]);
  throw SimulationFailed(FailureKind::stalled, cause);
}

}  // namespace selvedge::detail
