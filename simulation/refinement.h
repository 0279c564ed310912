// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/simulation/simulation.h>

#include <memory>
#include <optional>
#include <vector>

namespace selvedge {

/// The pieces of a scene whose cells are split as it runs ("refine").
///
/// A split moves no point of the surface (core/cloth_pattern.h), so a clean state stays clean. Only
/// hanging nodes may have left the side that they split; therefore the new state is checked, and a
/// split that leads to a crossing is postponed.
class Refinement {
 public:
  /// `built`: the scene as it starts. Throws std::invalid_argument if another part of the scene
  /// needs a mesh that does not change.
  Refinement(const Scene& scene, const BuiltScene& built,
             ClothPatternRegistry patterns = cloth_patterns());

  bool active() const { return !pieces_.empty(); }
  /// The splits that are due in `state`, which has the present cells.
  std::vector<SplitEvent> due(const SimulationState& state) const;
  /// Applies splits in order.
  void split(const std::vector<SplitEvent>& events);
  /// The same for a state with the present cells: mass and momentum are kept.
  void split(const std::vector<SplitEvent>& events, SimulationState& state);

  /// The scene with the present cells. A handle also holds the new nodes of a side that it holds.
  Scene scene() const;
  BuiltScene build() const;

 private:
  struct Piece {
    std::size_t number = 0;  // among the pieces of the scene
    RefineSpec spec;
    AdaptiveGrid grid;
    std::vector<Vec3> start;   // m, of its vertices at the start
    std::vector<double> mass;  // of the present cells
    double last = 0.0;         // s, when it was split last
  };

  void split(const SplitEvent& event, std::vector<Vec3>& x, std::vector<Vec3>& v);
  Piece& piece(std::int32_t number);
  std::vector<GridCell> due(const Piece& piece, std::span<const Vec3> x, std::span<const Vec3> v,
                            double time) const;
  std::size_t begin(std::size_t number) const;

  const Scene& scene_;
  ClothPatternRegistry patterns_;
  std::vector<Piece> pieces_;
  std::vector<std::size_t> sizes_;  // vertices of each piece of the scene
};

/// A simulation with finer cells, and the refinement that made it.
struct RefinedSimulation {
  Refinement refinement;
  std::unique_ptr<Simulation> simulation;
};
/// Applies the splits that are due in the state of `simulation`; nullopt if there are none. If the
/// result of the new simulation is not clean, the caller has to postpone the split.
std::optional<RefinedSimulation> split_due(const Refinement& refinement,
                                           const Simulation& simulation, const Methods& methods);

/// A simulation that splits its cells at the ends of frames where its scene has "refine". Behaves
/// as Simulation for other scenes.
class RefiningSimulation {
 public:
  /// Scene and methods must outlive it; throws what Simulation and Refinement throw.
  RefiningSimulation(const Scene& scene, BuiltScene built, const Methods& methods);

  /// The simulation with the present cells; `refine` replaces it.
  Simulation& now() { return *simulation_; }
  const Simulation& now() const { return *simulation_; }
  /// Applies the splits that are due. Call between two frames.
  void refine();
  /// Positions of the present vertices of the cloth at the start of the scene, m. New vertices are
  /// in the middle of the side that they split.
  std::vector<Vec3> start() const;
  /// The result since the start, over all splits.
  RunResult result() const;

 private:
  const Methods& methods_;
  std::optional<Refinement> refinement_;  // never empty; replaced by a split
  std::vector<Vec3> start_;
  std::unique_ptr<Simulation> simulation_;
  RunResult before_;
  bool was_split_ = false;
};

}  // namespace selvedge
