// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/build.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <cstdint>
#include <set>
#include <span>
#include <vector>

namespace selvedge {

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
  /// if they did not collide on the way.
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

}  // namespace selvedge
