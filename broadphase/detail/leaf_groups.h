// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/raw_array.h>
#include <selvedge/core/base/collision_types.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Maximum number of items of a leaf: eight bits can then count the lanes of its owned edges,
/// kMostOwned each.
inline constexpr int kMostLeafItems = 24;

/// The primitives of a surface in groups that become the leaves of a tree, from the topology alone.
/// Connected primitives stay near each other however the surface deforms, so these groups serve all
/// positions.
///
/// A group is a connected set of vertices, grown from its lowest vertex towards higher ones, always
/// from the lowest that it has reached. It contains the triangles whose lowest vertex is in the
/// set, and each edge and point that it contains is part of one of its triangles. The vertices are
/// divided into chunks of consecutive indices, and groups grow inside a chunk, so that all threads
/// work at the same time; the result does not depend on their number. O(vertices + edges +
/// triangles), except for vertices with very many edges, where a search adds a logarithm.
class LeafGroups {
 public:
  /// Groups of at most `most` triangles. The indices of the surface must have been checked.
  LeafGroups(const SurfaceView& surface, int most);

  std::size_t chunk_count() const { return chunks_.size(); }
  /// The groups are numbered from 0; those of a chunk are consecutive.
  std::size_t count() const { return count_; }
  std::int32_t first_group(std::size_t chunk) const { return chunks_[chunk].first_group; }
  std::int32_t end_group(std::size_t chunk) const {
    return chunks_[chunk].first_group + chunks_[chunk].groups;
  }
  /// Edges and points that belong to no triangle, and repeated edges.
  std::span<const std::int32_t> loose_edges() const { return loose_edges_; }
  std::span<const std::int32_t> loose_points() const { return loose_points_; }

  /// Calls visit(triangle, group) for each triangle of the chunk.
  template <class Visit>
  void each_triangle(std::size_t chunk, Visit visit) const {
    const std::int32_t first = chunks_[chunk].first_group;
    for (std::size_t i = triangle_begin_[chunk]; i < triangle_begin_[chunk + 1]; ++i)
      visit(triangle_at(i), first + triangle_group_[i]);
  }
  /// Calls visit(edge, group) for each edge that belongs to a group of the chunk.
  template <class Visit>
  void each_edge(std::size_t chunk, Visit visit) const {
    const std::int32_t first = chunks_[chunk].first_group;
    for (std::size_t p = edge_begin_[begin_of(chunk)]; p < edge_begin_[end_of(chunk)]; ++p)
      if (edge_group_[p] >= 0) visit(edge_at(p), first + edge_group_[p]);
    for (const Claim& claim : chunks_[chunk].edges) visit(edge_at(claim.item), first + claim.group);
  }
  /// Calls visit(point, group) for each point that belongs to a group of the chunk.
  template <class Visit>
  void each_point(std::size_t chunk, Visit visit) const {
    const std::int32_t first = chunks_[chunk].first_group;
    for (std::size_t v = begin_of(chunk); v < end_of(chunk); ++v)
      if (point_group_[v] >= 0) visit(static_cast<std::int32_t>(v), first + point_group_[v]);
    for (const Claim& claim : chunks_[chunk].points)
      visit(static_cast<std::int32_t>(claim.item), first + claim.group);
  }

 private:
  /// An edge (by its place) or a point that a group takes although it is keyed by another vertex.
  struct Claim {
    std::uint32_t item;
    std::int32_t group;
  };
  struct Chunk {
    std::int32_t groups = 0, first_group = 0;
    std::vector<Claim> edges, points;
    std::vector<std::int32_t> loose_edges, loose_points;
  };

  std::size_t begin_of(std::size_t chunk) const { return chunk << shift_; }
  std::size_t end_of(std::size_t chunk) const { return std::min(vertices_, (chunk + 1) << shift_); }
  std::int32_t triangle_at(std::size_t i) const {
    return triangle_order_.empty() ? static_cast<std::int32_t>(i) : triangle_order_[i];
  }
  std::int32_t edge_at(std::size_t place) const {
    return edge_id_.empty() ? static_cast<std::int32_t>(place) : edge_id_[place];
  }
  bool are_edges_ascending() const;
  std::size_t index_edges();
  void sort_edges();
  void choose_chunks(std::size_t crossing);
  void distribute_triangles();
  std::size_t find_edge(std::int32_t lower, std::int32_t upper) const;
  void grow(std::size_t chunk);
  void claim_rest(std::size_t chunk);
  void settle_claims();
  void list_loose(std::size_t chunk);

  int most_;
  std::size_t vertices_;
  std::span<const Triangle> triangles_;
  std::span<const Edge> edges_;         ///< ascending, lower vertex first: of the surface or sorted
  std::vector<Edge> sorted_edges_;      ///< empty if those of the surface are in order
  std::vector<std::int32_t> edge_id_;   ///< of each sorted edge; empty: its place
  RawArray<std::uint32_t> edge_begin_;  ///< by lower vertex
  int shift_ = 0;                       ///< a chunk has 2^shift_ vertices
  RawArray<std::int32_t> triangle_order_;    ///< by chunk of the lowest vertex; empty: as they are
  std::vector<std::size_t> triangle_begin_;  ///< by chunk
  RawArray<std::int32_t> triangle_group_;    ///< by place in the order, within the chunk
  RawArray<std::int32_t> edge_group_;        ///< by place, within the chunk; < 0: not keyed there
  RawArray<std::int32_t> point_group_;
  RawArray<std::uint8_t> open_;  ///< by vertex: an edge or the point has no group yet
  std::vector<Chunk> chunks_;
  std::size_t count_ = 0;
  std::vector<std::int32_t> loose_edges_, loose_points_;
};

}  // namespace selvedge::detail
