// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/patterns/internal/adaptive_cloth.h>
#include <selvedge/simulation/internal/seam_merging.h>
#include <selvedge/simulation/simulation_state.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// The parts of a scene whose mesh changes as it runs: pieces whose cells are split and joined
/// ("refine"), and seams whose vertices merge ("merge"). A scene has one of the two.
///
/// A split moves no point of the surface (core/patterns/cloth_pattern.h), so a clean state stays
/// clean. Before quarters are joined, the vertices that go move on straight lines to the surface of
/// the whole cell. That motion is searched for collisions with all cloth and all bodies, exactly,
/// and a cell that would collide is postponed. The new state is checked all the same, and a change
/// that leads to a crossing is postponed.
class Refinement {
 public:
  /// `scene` must outlive it; `built`: the scene as it starts. Throws std::invalid_argument if
  /// another part of the scene needs a mesh that does not change.
  Refinement(const Scene& scene, const BuiltScene& built,
             ClothPatternRegistry patterns = cloth_patterns());

  bool active() const { return !pieces_.empty() || merging_.active(); }
  const SeamMerging& merging() const { return merging_; }
  /// The splits that are due in `state`, which has the present cells.
  std::vector<SplitEvent> due(const SimulationState& state) const;
  /// The joins that are due in the present state of `simulation`, and the number of cells that
  /// would be joined if they did not collide on the way.
  struct Joins {
    std::vector<SplitEvent> events;
    std::vector<Vec3> way_end;  ///< m, of the present cloth vertices: on the surface of the whole
    std::size_t postponed = 0;
  };
  Joins joins_due(const Simulation& simulation) const;
  /// Applies splits and joins in order.
  void split(const std::vector<SplitEvent>& events);
  /// The same for a state with the present cells: mass and momentum are kept.
  void split(const std::vector<SplitEvent>& events, SimulationState& state);
  /// Applies a merge to a state with the present vertices.
  void merge(const MergeEvent& event, SimulationState& state) { merging_.merge(event, state); }
  /// Applies the splits and merges of a saved state to the scene as it starts.
  void repeat(const SimulationState& state);

  /// The scene with the present cells and a fixed mesh. A handle also holds the new nodes of a side
  /// that it holds.
  Scene scene() const;
  BuiltScene build() const;

 private:
  struct Piece {
    std::size_t number = 0;  // among the pieces of the scene
    RefineSpec spec;
    AdaptiveCloth cells;
    std::vector<Vec3> start;   // m, of its vertices at the start
    std::vector<double> mass;  // of the present cells
    double last = 0.0;         // s, when it was split last
  };

  void split(const SplitEvent& event, std::vector<Vec3>& x, std::vector<Vec3>& v);
  std::vector<Vec3> way_end(std::span<const Vec3> x, const std::vector<SplitEvent>& joins) const;
  Piece& piece(std::int32_t number);
  std::vector<GridCell> due(const Piece& piece, std::span<const Vec3> x, std::span<const Vec3> v,
                            double time) const;
  const Piece& piece(std::int32_t number) const;
  std::size_t begin(std::size_t number) const;

  const Scene* scene_;
  ClothPatternRegistry patterns_;
  std::vector<Piece> pieces_;
  std::vector<std::size_t> sizes_;  // vertices of each piece of the scene
  SeamMerging merging_;
};

}  // namespace selvedge::detail
