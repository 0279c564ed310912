// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/dop.h>
#include <selvedge/broadphase/detail/leaf_groups.h>

#include <vector>

namespace selvedge::detail {

/// References to a child of a node: a node by its index, a leaf by the complement of its index.
inline constexpr std::int32_t kNoChild = std::numeric_limits<std::int32_t>::min();

struct TreeShape {
  int arity = kLanes;      ///< children of a node, 2 to 8
  int leaf_size = kLanes;  ///< items of a leaf, 1 to kMostLeafItems
};

/// An item of a tree is its box; the fourth number of `lo` holds the bits of its index.
inline std::int32_t item_index(const FloatBox& item) {
  return Eigen::numext::bit_cast<std::int32_t>(item.lo[3]);
}

/// The nodes and leaves of a tree, without volumes.
struct TreeSkeleton {
  struct Node {
    std::int32_t child[kLanes];  ///< kNoChild from the first unused lane on
  };
  struct Range {
    std::int32_t begin, end;
  };

  std::vector<Node> nodes;    ///< a child comes after its parent
  std::vector<Range> leaves;  ///< of items
  /// Nodes below subtree_begin[0] are the top; subtree i ends where i + 1 begins.
  std::vector<std::size_t> subtree_begin = {0};

  std::size_t bytes() const;
};

/// Builds a tree over `items`, which it reorders to the order of the leaves, by binned surface-area
/// splits [Wald2007] with bins only on the longest axis of the centroids. The tree does not depend
/// on the number of threads.
void build_tree(const TreeShape& shape, std::vector<FloatBox>& items,
                std::vector<FloatBox>& scratch, TreeSkeleton& out);

}  // namespace selvedge::detail
