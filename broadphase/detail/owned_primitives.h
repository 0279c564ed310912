// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>

namespace selvedge::detail {

/// A triangle owns at most so many edges; with unique edges it has three, and a list that repeats
/// edges keeps the rest as items of their own.
inline constexpr int kMostOwned = 8;

/// Which triangle every vertex and every edge of a surface belongs to, its owner [Curtis2008], so
/// that a traversal by triangles meets each pair of primitives once. The items of a tree are the
/// triangles, then the edges, then the points without a triangle.
struct OwnedPrimitives {
  std::size_t vertex_count = 0;
  std::vector<Triangle> triangles;
  std::vector<Edge> edges;
  std::vector<std::int32_t> loose_edges, loose_points;
  std::vector<std::uint32_t> owned_edges_begin, owned_points_begin;  ///< per triangle
  std::vector<std::int32_t> owned_edges, owned_points;

  void set(const SurfaceView& surface);
  /// True if the surface has the very triangles and edges that this was made for.
  bool equal(const SurfaceView& surface) const;
  std::size_t item_count() const {
    return triangles.size() + loose_edges.size() + loose_points.size();
  }
  std::size_t bytes() const;

 private:
  void find_owners();
};

}  // namespace selvedge::detail
