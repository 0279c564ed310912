// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>

#include <array>
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
  std::vector<Triangle> triangles;
  std::vector<Edge> edges;
  std::vector<std::int32_t> loose_edges, loose_points;
  std::vector<std::uint32_t> owned_edges_begin, owned_points_begin;  ///< per triangle
  std::vector<std::int32_t> owned_edges, owned_points;

  void set(const SurfaceView& surface);
  /// Assigns owners to edges and points. Triangles of one `group` (0, 1, ... for each triangle)
  /// will share a leaf; owners are chosen so that groups own similar numbers, at most `most_edges`
  /// each. Empty: each triangle is a group.
  void find_owners(std::span<const std::int32_t> group, int most_edges);
  /// The first two triangles at each edge, -1 if there is none; valid until forget_sides.
  std::span<const std::array<std::int32_t, 2>> sides() const { return sides_; }
  /// Frees the data that only find_owners and sides need.
  void forget_sides();
  /// True if the surface has exactly the triangles and edges for which this was made.
  bool equal(const SurfaceView& surface) const;
  std::size_t item_count() const {
    return triangles.size() + loose_edges.size() + loose_points.size();
  }
  std::size_t bytes() const;

 private:
  /// Triangles around each vertex.
  struct VertexTriangles {
    std::vector<std::uint32_t> begin;
    std::vector<std::int32_t> triangle;

    void set(std::span<const Triangle> triangles, std::size_t n);
    std::span<const std::int32_t> of(std::size_t v) const {
      return {triangle.data() + begin[v], begin[v + 1] - begin[v]};
    }
  };

  void find_sides();

  VertexTriangles around_;
  std::vector<std::array<std::int32_t, 2>> sides_;
};

}  // namespace selvedge::detail
