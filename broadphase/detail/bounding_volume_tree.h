// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/leaf_groups.h>
#include <selvedge/broadphase/detail/obb.h>
#include <selvedge/broadphase/detail/owned_primitives.h>
#include <selvedge/broadphase/detail/tree_builder.h>

#include <concepts>

namespace selvedge::detail {

/// The volumes of a tree: slabs along `axes` directions, and an oriented box around each subtree if
/// `oriented`.
template <class V>
concept BoundingVolume = requires {
  { V::axes } -> std::convertible_to<int>;
  { V::oriented } -> std::convertible_to<bool>;
};

struct AabbVolume {
  static constexpr int axes = 3;
  static constexpr bool oriented = false;
};
/// Slabs with k sides: 14, 18 or 26.
template <int k>
struct KDopVolume {
  static constexpr int axes = k / 2;
  static constexpr bool oriented = false;
};
/// Axis-aligned boxes, and oriented boxes around nodes and leaves, which are tested where the
/// axis-aligned ones overlap.
struct ObbVolume {
  static constexpr int axes = 3;
  static constexpr bool oriented = true;
};

struct NoOrientation {};

template <BoundingVolume V>
struct alignas(32) VolumeNode {
  DopBlock<V::axes> boxes;
  [[no_unique_address]] std::conditional_t<V::oriented, ObbBlock, NoOrientation> obbs;
  FloatDop<V::axes> box;  ///< around all children
  [[no_unique_address]] std::conditional_t<V::oriented, FloatObb, NoOrientation> obb;
  std::int32_t child[kLanes];  ///< kNoChild from the first unused lane on
};

template <int axes>
struct alignas(32) DopPointBlock {
  DopBlock<axes> boxes;
  std::int32_t id[kLanes];
};
template <int axes>
struct alignas(32) DopEdgeBlock {
  DopBlock<axes> boxes;
  std::int32_t id[kLanes], v0[kLanes], v1[kLanes];
};
template <int axes>
struct alignas(32) DopTriangleBlock {
  DopBlock<axes> boxes;
  std::int32_t id[kLanes], v0[kLanes], v1[kLanes], v2[kLanes];
};

/// Contents of a leaf: its triangles, and the edges and points that they own.
template <BoundingVolume V>
struct VolumeLeaf {
  FloatDop<V::axes> box;
  [[no_unique_address]] std::conditional_t<V::oriented, FloatObb, NoOrientation> obb;
  std::uint32_t point_block, edge_block, triangle_block;  ///< index of the first block of each kind
  std::uint8_t point_blocks, edge_blocks, triangle_blocks;  ///< number of blocks
  std::uint8_t points, edges, triangles;                    ///< number of used lanes in all blocks
  bool loose;  ///< some edge or point belongs to none of the triangles
};

/// Scratch memory for building or fitting; one object serves many trees in turn.
template <int axes>
struct TreeScratch {
  std::vector<FloatDop<axes>> vertex_boxes;
  std::vector<FloatBox> items, partitioned;
  std::vector<std::int32_t> item_order;  ///< the items in the order of the leaves
  TreeSkeleton skeleton;
  std::vector<Moments> node_moments;

  std::size_t bytes() const {
    return vertex_boxes.capacity() * sizeof(FloatDop<axes>) + skeleton.bytes() +
           (items.capacity() + partitioned.capacity()) * sizeof(FloatBox) +
           item_order.capacity() * sizeof(std::int32_t) + node_moments.capacity() * sizeof(Moments);
  }
};

/// An eight-wide tree of bounding volumes over the triangles of one surface, swept over the step
/// and inflated.
template <BoundingVolume V>
class VolumeTree {
 public:
  static constexpr int kAxes = V::axes;
  using Node = VolumeNode<V>;
  using Leaf = VolumeLeaf<V>;
  using Dop = FloatDop<kAxes>;
  using Scratch = TreeScratch<kAxes>;

  explicit VolumeTree(const TreeShape& shape = {}) : shape_(shape) {}

  /// True if the surface has exactly the triangles and edges for which this tree was made.
  bool has_topology_of(const SurfaceView& surface) const { return primitives_.equal(surface); }
  /// Sets a new topology, whose indices must have been checked; call build next.
  void set_topology(const SurfaceView& surface);

  /// Builds the tree for these positions.
  void build(const SurfaceView& surface, const TreePlace& place, Scratch& scratch);
  /// Keeps the structure of the tree and fits its volumes to these positions.
  void refit(const SurfaceView& surface, const TreePlace& place, Scratch& scratch);
  /// Tree quality loss: how much boxes overlap, relative to the last build (1). The measure is the
  /// mean over the nodes of the children's areas divided by the node's area, each ratio limited to
  /// 4 so that a few stretched triangles have little influence.
  double quality_loss() const { return quality_loss_; }

  bool empty() const { return leaves_.empty(); }
  /// Index of the root node, or the complement of the index of the only leaf.
  std::int32_t root() const { return nodes_.empty() ? ~0 : 0; }
  const Node& node(std::int32_t i) const { return nodes_[i]; }
  const Leaf& leaf(std::int32_t i) const { return leaves_[i]; }
  const DopPointBlock<kAxes>* points(const Leaf& leaf) const {
    return points_.data() + leaf.point_block;
  }
  const DopEdgeBlock<kAxes>* edges(const Leaf& leaf) const {
    return edges_.data() + leaf.edge_block;
  }
  const DopTriangleBlock<kAxes>* triangles(const Leaf& leaf) const {
    return triangles_.data() + leaf.triangle_block;
  }
  std::size_t vertex_count() const { return primitives_.vertex_count; }
  std::size_t edge_count() const { return primitives_.edges.size(); }
  std::size_t triangle_count() const { return primitives_.triangles.size(); }
  std::size_t node_count() const { return nodes_.size(); }
  std::size_t leaf_count() const { return leaves_.size(); }
  /// Changes whenever nodes and leaves are rebuilt; a refit keeps it. Never 0 for a built tree.
  std::uint64_t version() const { return version_; }
  /// Memory in bytes.
  std::size_t bytes() const;

 private:
  using Range = TreeSkeleton::Range;

  void box_vertices(const SurfaceView& surface, const TreePlace& place, Scratch& scratch) const;
  bool lay_out_groups(const SurfaceView& surface);
  void count_groups(const LeafGroups& groups);
  void fill_groups(const LeafGroups& groups);
  void add_loose_leaves(const LeafGroups& groups);
  void build_over_leaves(Scratch& scratch);
  void build_over_items(Scratch& scratch);
  void box_items(Scratch& scratch) const;
  void take_nodes(const TreeSkeleton& skeleton);
  void lay_out_leaves(std::span<const std::int32_t> items, std::span<const Range> ranges);
  void count_leaf(Leaf& leaf, std::span<const std::int32_t> items) const;
  void place_blocks();
  void fill_leaf(const Leaf& leaf, std::span<const std::int32_t> items);
  void set_point(const Leaf& leaf, int lane, std::int32_t v);
  void set_edge(const Leaf& leaf, int lane, std::int32_t e);
  void set_triangle(const Leaf& leaf, int lane, std::int32_t t);
  void clear_unused(const Leaf& leaf);
  void list_leaf_vertices();
  void fit(const SurfaceView& surface, const TreePlace& place, Scratch& scratch);
  void fit_leaves(const std::vector<Dop>& vertex_boxes);
  void fit_leaf(Leaf& leaf, const std::vector<Dop>& vertex_boxes);
  void fit_nodes();
  void fit_nodes(std::size_t begin, std::size_t end);
  void orient(const SurfaceView& surface, const TreePlace& place, Scratch& scratch);
  double measure_overlap() const;
  static double overlap_ratio(const Node& node);

  TreeShape shape_;
  bool grouped_ = false;  // leaves follow the topology
  OwnedPrimitives primitives_;
  std::vector<Node> nodes_;                       // a child comes after its parent
  std::vector<std::size_t> subtree_begin_ = {0};  // as in TreeSkeleton
  std::vector<Leaf> leaves_;
  RawArray<DopPointBlock<kAxes>> points_;
  RawArray<DopEdgeBlock<kAxes>> edges_;
  RawArray<DopTriangleBlock<kAxes>> triangles_;
  std::vector<std::uint32_t> leaf_vertices_begin_;  // of oriented trees only
  std::vector<std::int32_t> leaf_vertices_;
  double built_ratio_ = 1.0;
  double quality_loss_ = 1.0;
  std::uint64_t version_ = 0;
};

/// The tree of axis-aligned boxes.
using BoundingVolumeTree = VolumeTree<AabbVolume>;
using TreeNode = VolumeNode<AabbVolume>;
using TreeLeaf = VolumeLeaf<AabbVolume>;
using PointBlock = DopPointBlock<3>;
using EdgeBlock = DopEdgeBlock<3>;
using TriangleBlock = DopTriangleBlock<3>;

}  // namespace selvedge::detail
