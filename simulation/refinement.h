// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/adaptive_cloth.h>
#include <selvedge/simulation/simulation.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace selvedge {

/// What changes the mesh of a scene between frames: `cloth "skirt": "refine"`, or `seam "side":
/// "merge"`; "" if nothing does.
std::string mesh_change(const Scene& scene);
/// The scene without "refine" and "merge": a Simulation of it keeps the mesh that it is given.
Scene with_fixed_mesh(Scene scene);

/// The pairs of a scene's seams that become one vertex where a seam has closed ("merge" of
/// "seams").
///
/// The vertices of a pair move on straight lines to their centre of mass, or to the one that a
/// handle holds; mass and momentum are kept. Before they do, that motion is searched for collisions
/// with all cloth and all bodies, exactly. A pair that would collide is postponed. A pair stays
/// open if a handle holds both of its vertices, or if its merge would turn a triangle into an edge
/// or two triangles into one, as in the corner of a bag.
class SeamMerging {
 public:
  /// `scene` must outlive it; `built`: the scene as it starts. Throws std::invalid_argument if
  /// another part of the scene needs a mesh that does not change, or if contacts keep the pairs of
  /// a seam farther apart than its distance.
  SeamMerging(const Scene& scene, const BuiltScene& built, const ClothPatternRegistry& patterns);

  bool active() const { return !pairs_.empty(); }
  /// The pairs that merge in the present state of `simulation`, and the number of those that would
  /// if they did not collide on their paths.
  struct Due {
    MergeEvent event;
    std::size_t postponed = 0;
  };
  Due due(const Simulation& simulation) const;
  /// Applies a merge.
  void merge(const MergeEvent& event);
  /// The same for a state with the present vertices.
  void merge(const MergeEvent& event, SimulationState& state);

  /// The scene with the present vertices and a fixed mesh. Its handles hold the same particles.
  Scene scene() const;
  BuiltScene build() const;

 private:
  struct Pair {
    Edge vertices;    // of the scene as it was built, like all vertices here
    double distance;  // m
  };
  using Owners = std::vector<std::int32_t>;  // of each vertex, the one that it is now
  /// From the present vertices to those after a merge.
  struct Change {
    std::vector<std::int32_t> after;
    std::vector<double> mass;  // kg
    std::vector<char> held;
    std::size_t count = 0;  // of vertices after it

    std::vector<Vec3> means(std::span<const Vec3> u) const;
  };

  static std::vector<std::int32_t> numbers(const Owners& owner);
  void unite(const Edge& pair, Owners& owner) const;
  bool keeps_surface(const Edge& pair, const Owners& before) const;
  std::vector<Edge> closed(std::span<const Vec3> x) const;
  Change change_to(const Owners& owner) const;
  std::set<std::int32_t> colliding(const Simulation& simulation, const Change& change) const;
  std::size_t remove_colliding(const Simulation& simulation, std::vector<Edge>& pairs) const;

  const Scene* scene_;
  ClothPatternRegistry patterns_;
  std::vector<Pair> pairs_;
  std::vector<double> mass_;
  std::vector<std::int32_t> begin_;  // first vertex of each piece, plus the total
  std::vector<Triangle> triangles_;
  std::vector<std::vector<std::int32_t>> around_;  // triangles of each vertex
  std::vector<char> held_;
  Owners owner_;
};

/// The parts of a scene whose mesh changes as it runs: pieces whose cells are split and joined
/// ("refine"), and seams whose vertices merge ("merge"). A scene has one of the two.
///
/// A split moves no point of the surface (core/cloth_pattern.h), so a clean state stays clean.
/// Before quarters are joined, the vertices that go move on straight lines to the surface of the
/// whole cell. That motion is searched for collisions with all cloth and all bodies, exactly, and a
/// cell that would collide is postponed. The new state is checked all the same, and a change that
/// leads to a crossing is postponed.
class Refinement {
 public:
  /// `built`: the scene as it starts. Throws std::invalid_argument if another part of the scene
  /// needs a mesh that does not change.
  Refinement(const Scene& scene, const BuiltScene& built,
             ClothPatternRegistry patterns = cloth_patterns());

  bool active() const { return !pieces_.empty() || merging_.active(); }
  const SeamMerging& merging() const { return merging_; }
  /// The splits that are due in `state`, which has the present cells.
  std::vector<SplitEvent> due(const SimulationState& state) const;
  /// The joins that are due in the present state of `simulation`, and the number of cells that
  /// would be joined if they did not collide on their paths.
  struct Joins {
    std::vector<SplitEvent> events;
    std::size_t postponed = 0;
  };
  Joins joins_due(const Simulation& simulation) const;
  /// Applies splits and joins in order.
  void split(const std::vector<SplitEvent>& events);
  /// The same for a state with the present cells: mass and momentum are kept.
  void split(const std::vector<SplitEvent>& events, SimulationState& state);
  /// Applies a merge to a state with the present vertices.
  void merge(const MergeEvent& event, SimulationState& state) { merging_.merge(event, state); }
  /// Applies the splits and merges of a saved state; returns a simulation that continues from it.
  std::unique_ptr<Simulation> restored(const SimulationState& state, const Methods& methods);

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
  std::set<std::int32_t> colliding(const Simulation& simulation,
                                   const std::vector<SplitEvent>& joins) const;
  Piece& piece(std::int32_t number);
  std::vector<GridCell> due(const Piece& piece, std::span<const Vec3> x, std::span<const Vec3> v,
                            double time) const;
  const Piece& piece(std::int32_t number) const;
  std::size_t begin(std::size_t number) const;

  const Scene& scene_;
  ClothPatternRegistry patterns_;
  std::vector<Piece> pieces_;
  std::vector<std::size_t> sizes_;  // vertices of each piece of the scene
  SeamMerging merging_;
};

/// A simulation with another mesh, and the refinement that made it.
struct RefinedSimulation {
  Refinement refinement;
  std::unique_ptr<Simulation> simulation;  ///< null if all that is due is postponed
  std::string counter;  ///< of RunResult: "refinements", "joined_cells" or "merged_pairs"
  double count = 1.0, postponed = 0.0;

  /// Whether the change can be made: its state has no crossing. Adds it to the counters of `r`,
  /// or else to those of postponed changes.
  bool settle(RunResult& r) const;
};
/// Applies the splits and merges that are due in the state of `simulation`; nullopt if there are
/// none. The caller has to ask `settle` whether the change stands.
std::optional<RefinedSimulation> split_due(const Refinement& refinement,
                                           const Simulation& simulation, const Methods& methods);

/// Joins the quarters of cells that are due in the state of `simulation`, as split_due. Both are
/// asked between two frames, this one last.
std::optional<RefinedSimulation> join_due(const Refinement& refinement,
                                          const Simulation& simulation, const Methods& methods);

/// A simulation that splits and joins its cells and merges its seams between frames where its scene
/// has "refine" or "merge". Behaves as Simulation for other scenes. All that runs a scene frame by
/// frame (run_scene, `selvedge compare`, the Python module) begins its frames here.
class RefiningSimulation {
 public:
  /// Called around a change of the mesh, which replaces `now()`; each may be empty.
  struct Exchange {
    std::function<void()> before;  ///< `now()` is still the simulation that ends
    std::function<void()> after;
  };

  /// Scene and methods must outlive it; throws what Simulation and Refinement throw.
  RefiningSimulation(const Scene& scene, BuiltScene built, const Methods& methods);
  /// Continues from a state of the scene, whose start is not checked, as Simulation does.
  RefiningSimulation(const Scene& scene, BuiltScene built, SimulationState state,
                     const Methods& methods);

  /// The simulation with the present mesh; `begin_frame` replaces it.
  Simulation& now() { return *simulation_; }
  const Simulation& now() const { return *simulation_; }
  /// The same, for those that keep views of its arrays when it has been replaced.
  std::shared_ptr<const Simulation> shared() const { return simulation_; }
  /// Whether the mesh may change.
  bool changes_mesh() const { return refinement_->active(); }

  /// Applies the splits, merges and joins that are due, once at each frame. Does nothing between
  /// frames.
  void begin_frame(const Exchange& exchange = {});
  /// Whether that was done at the frame whose time is reached.
  bool frame_has_begun() const { return begun_ == simulation_->frame(); }
  /// Simulation::step and step_towards; a step from a frame begins it.
  void step();
  bool step_towards(int frame);
  /// Advances to the time of frame `frame`, and begins and verifies every frame on the way.
  /// `accepted`: see Simulation.
  void advance_to_frame(int frame, const std::function<void(double time)>& accepted = {});

  /// Continues from `state`, to the same bits; `before`: the result of the run until then.
  /// `has_begun`: begin_frame has been called at the frame of the state.
  void restore(SimulationState state, bool has_begun = false, RunResult before = {});

  /// Positions of the present vertices of the cloth at the start of the scene, m. New vertices are
  /// in the middle of the side that they split.
  std::vector<Vec3> start() const;
  /// The result since the start, over all changes of the mesh and, after `restore`, all parts of
  /// the run.
  RunResult result() const;

 private:
  void change(std::optional<RefinedSimulation> next, const Exchange& exchange);

  const Methods& methods_;
  std::optional<Refinement> refinement_;  // never empty; replaced by a change
  std::vector<Vec3> start_;
  std::shared_ptr<Simulation> simulation_;
  RunResult before_;  // of the parts before a change or a restore
  int begun_ = -1;    // last frame that has begun
  bool was_changed_ = false;
};

}  // namespace selvedge
