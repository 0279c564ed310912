// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/simulation.h>

#include <memory>
#include <optional>
#include <vector>

namespace selvedge {

/// The pieces of a scene whose cells are split as it runs ("refine").
///
/// A split moves no point of the surface (adaptive_grid.h), so a clean state stays clean; it is
/// looked at all the same, because hanging nodes may have been pushed off the sides that they split
/// then, and whoever finds a crossing leaves the split for later.
class Refinement {
 public:
  /// `built`: the scene as it starts. Throws std::invalid_argument where something else in the
  /// scene needs a mesh that stays as it is.
  Refinement(const Scene& scene, const BuiltScene& built);

  bool active() const { return !pieces_.empty(); }
  /// What is to be split in `state`, which has the present cells; empty: nothing.
  std::vector<SplitEvent> due(const SimulationState& state) const;
  /// Splits, in order.
  void split(const std::vector<SplitEvent>& events);
  /// The same for a state with the present cells: mass and momentum are kept.
  void split(const std::vector<SplitEvent>& events, SimulationState& state);

  /// The scene with the present cells: new nodes of a side that a handle holds are held too.
  Scene scene() const;
  BuiltScene build() const;

 private:
  struct Piece {
    std::size_t number = 0;  // among the pieces of the scene
    RefineSpec spec;
    AdaptiveGrid grid;
    std::vector<Vec3> start;   // where its vertices are at the start
    std::vector<double> mass;  // of the present cells
    double last = 0.0;         // s, when it was split last
  };

  void split(const SplitEvent& event, std::vector<Vec3>& x, std::vector<Vec3>& v);
  Piece& piece(std::int32_t number);
  std::vector<GridCell> due(const Piece& piece, std::span<const Vec3> x, std::span<const Vec3> v,
                            double time) const;
  std::size_t begin(std::size_t number) const;

  const Scene& scene_;
  std::vector<Piece> pieces_;
  std::vector<std::size_t> sizes_;  // vertices of each piece of the scene
};

/// A simulation with finer cells, and what it was made with.
struct RefinedSimulation {
  Refinement refinement;
  std::unique_ptr<Simulation> simulation;
};
/// Splits what is due in the state of `simulation`; none if nothing is. Its result says whether the
/// new state is clean; the caller leaves the split for later if not.
std::optional<RefinedSimulation> split_due(const Refinement& refinement,
                                           const Simulation& simulation, const Methods& methods);

/// A simulation that splits its cells at the ends of frames, as its scene asks. Of a scene without
/// "refine" it is just that.
class RefiningSimulation {
 public:
  /// Scene and methods must outlive it; throws what Simulation and Refinement throw.
  RefiningSimulation(const Scene& scene, BuiltScene built, const Methods& methods);

  /// The one with the present cells; another one after refine.
  Simulation& now() { return *simulation_; }
  const Simulation& now() const { return *simulation_; }
  /// To be called between two frames.
  void refine();
  /// Where the present vertices of the cloth are at the start of the scene, m: new ones between
  /// those whose side they split.
  std::vector<Vec3> start() const;
  /// From the start on, of all simulations.
  RunResult result() const;

 private:
  const Methods& methods_;
  std::optional<Refinement> refinement_;  // never empty; another one after a split
  std::vector<Vec3> start_;
  std::unique_ptr<Simulation> simulation_;
  RunResult before_;
  bool was_split_ = false;
};

}  // namespace selvedge
