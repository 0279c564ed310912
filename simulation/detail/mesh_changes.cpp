// SPDX-License-Identifier: MIT
#include <selvedge/simulation/detail/mesh_changes.h>

#include <utility>

namespace selvedge {
namespace {

detail::DueChange due_merges(const SeamMerging::Due& due) {
  return {.counter = "merged_pairs",
          .count = static_cast<double>(due.event.pairs.size()),
          .postponed = static_cast<double>(due.postponed),
          .merge = due.event};
}

/// The state after a change. Integrators of several steps and friction start anew; pinches are
/// found again in the next step.
SimulationState state_after(const detail::DueChange& due, SimulationState state,
                            detail::Refinement& refinement) {
  if (due.splits.empty())
    refinement.merge(due.merge, state);
  else
    refinement.split(due.splits, state);
  state.step += due.way_end.empty() ? 1 : 2;  // the end of the way is a state of its own
  state.memory.clear();
  state.contact_memory.clear();
  state.pinches.clear();
  state.still = 0.0;
  return state;
}

PassedState state_of(const Simulation& simulation) {
  const SimulationState& now = simulation.state();
  const std::span<const Triangle> triangles = simulation.cloth_triangles();
  return {now.step, now.x, now.v, simulation.flags(), {triangles.begin(), triangles.end()}};
}

}  // namespace

detail::DueChange Simulation::MeshChanges::splits_or_merges(const Simulation& simulation) const {
  if (refinement.merging().active()) return due_merges(refinement.merging().due(simulation));
  std::vector<SplitEvent> splits = refinement.due(simulation.state());
  const double count = splits.empty() ? 0.0 : 1.0;
  return {.counter = "refinements", .count = count, .splits = std::move(splits)};
}

detail::DueChange Simulation::MeshChanges::joins(const Simulation& simulation) const {
  detail::Refinement::Joins joins = refinement.joins_due(simulation);
  detail::DueChange due{.counter = "joined_cells",
                        .postponed = static_cast<double>(joins.postponed)};
  for (const SplitEvent& event : joins.events) due.count += static_cast<double>(event.cells.size());
  due.splits = std::move(joins.events);
  if (!due.splits.empty()) due.way_end = std::move(joins.way_end);
  return due;
}

bool Simulation::MeshChanges::make(const detail::DueChange& due, std::shared_ptr<Parts>& parts) {
  const auto count = [&](RunResult& result, double done) {
    const double late = due.postponed + due.count - done;
    if (done > 0.0) result.counters[due.counter] += done;
    if (late > 0.0) result.counters[due.counter + "_postponed"] += late;
  };
  if (due.count > 0.0) {
    detail::Refinement changed = refinement;
    SimulationState state = state_after(due, parts->state, changed);
    if (const auto next = parts_at(changed, std::move(state)); next->verifies_clean()) {
      RunResult before = parts->present_result();
      count(before, due.count);
      next->continue_from(std::move(before));
      refinement = std::move(changed);
      parts = next;
      return true;
    }
  }
  count(parts->before, 0.0);
  return false;
}

void Simulation::MeshChanges::note_passed(PassedState before, const detail::DueChange& joins,
                                          bool was_split) {
  if (was_split) passed.push_back(before);
  ++before.step;
  before.x = joins.way_end;
  passed.push_back(std::move(before));
}

void Simulation::MeshChanges::repeat(const SimulationState& state, const BuiltScene& built) {
  refinement = detail::Refinement(scene, built, methods.patterns);
  refinement.repeat(state);
}

std::shared_ptr<Simulation::Parts> Simulation::MeshChanges::parts_at(const detail::Refinement& of,
                                                                     SimulationState state) const {
  auto parts = std::make_shared<Parts>(of.scene(), of.build(), methods);
  parts->continue_at(std::move(state));
  return parts;
}

std::span<const PassedState> Simulation::passed() const {
  return changes_ ? std::span<const PassedState>(changes_->passed) : std::span<const PassedState>();
}

// What happens at the boundary of a frame: first splits or merges, then joins, once at each frame.
bool Simulation::change_mesh() {
  if (!changes_) return false;
  changes_->passed.clear();
  if (parts_->state.refined || !is_at_frame()) return false;
  parts_->state.refined = true;
  const bool measures = measures_wrenches();
  const bool first = changes_->make(changes_->splits_or_merges(*this), parts_);
  const detail::DueChange joins = changes_->joins(*this);
  PassedState before;
  if (joins.count > 0.0) before = state_of(*this);
  const bool second = changes_->make(joins, parts_);
  if (second) changes_->note_passed(std::move(before), joins, first);
  parts_->measure_wrenches(measures);
  return first || second;
}

}  // namespace selvedge
