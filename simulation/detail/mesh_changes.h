// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/simulation/detail/refinement.h>
#include <selvedge/simulation/detail/simulation_parts.h>

#include <memory>
#include <string>
#include <vector>

namespace selvedge::detail {

/// Whether the mesh of a state is another one than at the start.
inline bool has_changes(const SimulationState& state) {
  return !state.splits.empty() || !state.merges.empty();
}

/// A change of the mesh that is due at a frame.
struct DueChange {
  std::string counter;  ///< of RunResult: "refinements", "joined_cells" or "merged_pairs"
  double count = 0.0, postponed = 0.0;
  std::vector<SplitEvent> splits{};  ///< and joins
  MergeEvent merge{};
  std::vector<Vec3> way_end{};  ///< m, of the cloth vertices before a join; empty: they stay
};

}  // namespace selvedge::detail

namespace selvedge {

/// How the mesh of a simulation changes. Owns what it was made from.
struct Simulation::MeshChanges {
  const Scene scene;
  const Methods methods;
  detail::Refinement refinement;    ///< of the present mesh
  std::vector<PassedState> passed;  ///< of the last step

  MeshChanges(const Scene& s, const BuiltScene& built, const Methods& m)
      : scene(s), methods(m), refinement(scene, built, methods.patterns) {}

  /// The splits or merges that are due in the state of `simulation`, and the joins.
  detail::DueChange splits_or_merges(const Simulation& simulation) const;
  detail::DueChange joins(const Simulation& simulation) const;
  /// Makes a change, and `parts` those of its mesh. Postpones all of it if its state has a
  /// crossing. Counts what it has done. Returns whether the mesh has changed.
  bool make(const detail::DueChange& due, std::shared_ptr<Parts>& parts);
  /// Notes the states before and at the end of the way of joins that have been made. `before` is
  /// one that the step passed through only if it has split cells, too.
  void note_passed(PassedState before, const detail::DueChange& joins, bool was_split);
  /// Makes the changes that led to a state of the scene, which starts as `built`.
  void repeat(const SimulationState& state, const BuiltScene& built);
  /// Parts with the mesh of `of` that continue from a state.
  std::shared_ptr<Parts> parts_at(const detail::Refinement& of, SimulationState state) const;
};

}  // namespace selvedge
