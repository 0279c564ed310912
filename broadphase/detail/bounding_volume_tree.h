// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace selvedge::detail {

/// Number of boxes that are tested together.
inline constexpr int kLanes = 8;
/// A triangle owns at most so many edges; with unique edges it has three, and a list that repeats
/// edges keeps the rest as items of their own. A leaf thus has at most so many edge blocks.
inline constexpr int kMostOwned = 8;
/// Lanes and leaves refer to a tree node by its index, to a leaf by the complement of its index.
inline constexpr std::int32_t kNoChild = std::numeric_limits<std::int32_t>::min();

/// A box in float, the fourth number of each corner unused.
///
/// Why float loses nothing: every coordinate d of a double box, lower or upper, goes through the
/// same map m(d) = clamp(float(d - origin)), whose roundings are monotone. So lo(a) <= hi(b) in
/// double implies m(lo(a)) <= m(hi(b)): no pair is lost. And m(lo(a)) < m(hi(b)) implies
/// lo(a) < hi(b): a pair whose float boxes overlap strictly is certain, and only a pair that is
/// equal in some coordinate must be looked at again in double.
struct alignas(16) FloatBox {
  std::array<float, 4> lo, hi;
};

/// Eight boxes, by coordinate. Lanes that are not used are NaN, so that they overlap nothing.
struct alignas(32) BoxBlock {
  float lo[3][kLanes];
  float hi[3][kLanes];
};

struct alignas(32) TreeNode {
  BoxBlock boxes;
  FloatBox box;                ///< around all of them
  std::int32_t child[kLanes];  ///< kNoChild from the first unused lane on
};

struct alignas(32) PointBlock {
  BoxBlock boxes;
  std::int32_t id[kLanes];
};
struct alignas(32) EdgeBlock {
  BoxBlock boxes;
  std::int32_t id[kLanes], v0[kLanes], v1[kLanes];
};
struct alignas(32) TriangleBlock {
  BoxBlock boxes;
  std::int32_t id[kLanes], v0[kLanes], v1[kLanes], v2[kLanes];
};

/// What a leaf holds: at most eight triangles, and the edges and points that they own.
struct TreeLeaf {
  FloatBox box;
  std::uint32_t point_block, edge_block, triangle_block;    ///< the first of each
  std::uint8_t point_blocks, edge_blocks, triangle_blocks;  ///< how many
  std::uint8_t points, edges, triangles;                    ///< how many lanes in all of them
};

/// Room that trees need only while they are built or fitted; one serves many, one after another.
struct TreeScratch {
  std::vector<FloatBox> vertex_boxes;
  /// Boxes of the items of a tree; the fourth number of `lo` holds the bits of the item's index.
  std::vector<FloatBox> items, partitioned;

  std::size_t bytes() const {
    return (vertex_boxes.capacity() + items.capacity() + partitioned.capacity()) * sizeof(FloatBox);
  }
};

/// An eight-wide tree of axis-aligned boxes over the triangles of one surface, swept over the step
/// and inflated. Every vertex and every edge belongs to one of its triangles, its owner
/// [Curtis2008], so that a traversal by triangles meets each pair of primitives once. Points and
/// edges without a triangle are items of their own.
class BoundingVolumeTree {
 public:
  /// True if the surface has the very triangles and edges that this tree was made for.
  bool has_topology_of(const SurfaceView& surface) const;
  /// Takes over a new topology; the tree must be built next. Indices must have been checked.
  void set_topology(const SurfaceView& surface);

  /// Makes the tree for these positions by binned surface-area splits [Wald2007].
  void build(const SurfaceView& surface, const Vec3& origin, TreeScratch& scratch);
  /// Keeps the tree and fits its boxes to these positions.
  void refit(const SurfaceView& surface, const Vec3& origin, TreeScratch& scratch);
  /// How much boxes overlap, relative to the last build (1): the mean over the nodes of the areas
  /// of the children over the area of the node, each at most 4 so that a few far stretched
  /// triangles count little.
  double looseness() const { return looseness_; }

  bool empty() const { return leaves_.empty(); }
  /// Index of the root node, or the complement of the index of the only leaf.
  std::int32_t root() const { return nodes_.empty() ? ~0 : 0; }
  const TreeNode& node(std::int32_t i) const { return nodes_[i]; }
  const TreeLeaf& leaf(std::int32_t i) const { return leaves_[i]; }
  const PointBlock* points(const TreeLeaf& leaf) const { return points_.data() + leaf.point_block; }
  const EdgeBlock* edges(const TreeLeaf& leaf) const { return edges_.data() + leaf.edge_block; }
  const TriangleBlock* triangles(const TreeLeaf& leaf) const {
    return triangles_.data() + leaf.triangle_block;
  }
  std::size_t vertex_count() const { return vertex_count_; }
  std::size_t edge_count() const { return topology_edges_.size(); }
  std::size_t triangle_count() const { return topology_triangles_.size(); }
  std::size_t node_count() const { return nodes_.size(); }
  std::size_t leaf_count() const { return leaves_.size(); }
  /// Changes whenever nodes and leaves are made anew; a refit keeps it. Never 0 for a built tree.
  std::uint64_t version() const { return version_; }
  /// Memory held.
  std::size_t bytes() const;

 private:
  struct Range {
    std::int32_t begin, end;
  };
  struct Subtree;
  struct Builder;

  void find_owners();
  void box_items(TreeScratch& scratch) const;
  void split_items(TreeScratch& scratch);
  void join(Subtree& top, const std::vector<Subtree>& below);
  void lay_out_leaves(const std::vector<FloatBox>& items);
  void fit_leaves(const std::vector<FloatBox>& vertex_boxes);
  void fit_nodes();
  void fit_nodes(std::size_t begin, std::size_t end);
  double measure_looseness() const;
  static double overlap_ratio(const TreeNode& node);
  FloatBox fit_points(const TreeLeaf& leaf, const std::vector<FloatBox>& vertex_boxes);
  FloatBox fit_edges(const TreeLeaf& leaf, const std::vector<FloatBox>& vertex_boxes);
  FloatBox fit_triangles(const TreeLeaf& leaf, const std::vector<FloatBox>& vertex_boxes);

  // Topology: items are the triangles, then the edges and then the points without a triangle.
  std::size_t vertex_count_ = 0;
  std::vector<Triangle> topology_triangles_;
  std::vector<Edge> topology_edges_;
  std::vector<std::int32_t> loose_edges_, loose_points_;
  std::vector<std::uint32_t> owned_edges_begin_, owned_points_begin_;  // per triangle
  std::vector<std::int32_t> owned_edges_, owned_points_;

  // The tree.
  std::vector<TreeNode> nodes_;  // a child comes after its parent
  // Nodes below subtree_begin_[0] are the top; subtree i ends where i + 1 begins.
  std::vector<std::size_t> subtree_begin_ = {0};
  std::vector<TreeLeaf> leaves_;
  std::vector<Range> leaf_items_;
  std::vector<PointBlock> points_;
  std::vector<EdgeBlock> edges_;
  std::vector<TriangleBlock> triangles_;
  double built_ratio_ = 1.0;
  double looseness_ = 1.0;
  std::uint64_t version_ = 0;
};

}  // namespace selvedge::detail
