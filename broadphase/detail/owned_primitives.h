// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/raw_array.h>
#include <selvedge/core/base/collision_types.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// Maximum number of edges that a triangle owns. With unique edges it owns at most three; of a list
/// that repeats edges, the others become separate items.
inline constexpr int kMostOwned = 8;

/// Assigns every vertex and every edge of a surface to one triangle, its owner [Curtis2008], so
/// that a traversal by triangles finds each pair of primitives once. The items of a tree are the
/// triangles, then the edges, then the points without a triangle.
struct OwnedPrimitives {
  std::size_t vertex_count = 0;
  RawArray<Triangle> triangles;
  RawArray<Edge> edges;
  std::vector<std::int32_t> loose_edges, loose_points;
  std::vector<std::uint32_t> owned_edges_begin, owned_points_begin;  ///< per triangle
  std::vector<std::int32_t> owned_edges, owned_points;

  void set(const SurfaceView& surface);
  /// Assigns owners to edges and points, so that triangles own similar numbers.
  void find_owners();
  /// The owners are not needed: all edges and points have places, except these.
  void set_loose(std::span<const std::int32_t> edges, std::span<const std::int32_t> points);
  /// True if the surface has exactly the triangles and edges for which this was made.
  bool equal(const SurfaceView& surface) const;
  std::size_t item_count() const {
    return triangles.size() + loose_edges.size() + loose_points.size();
  }
  std::size_t bytes() const;
};

}  // namespace selvedge::detail
