// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/bounding_volume_tree.h>
#include <selvedge/broadphase/detail/collect_pairs.h>

#include <vector>

namespace selvedge::detail {

/// A node or leaf of the first tree and one of the second, whose volumes overlap (for a tree with
/// itself, the two may be the same).
struct TreePair {
  std::int32_t a, b;
};

/// Subtrees that need no test against themselves: no two primitives that both belong to triangles
/// below such a node or leaf can touch during the step, except those that share a vertex. They are
/// still tested against the rest of the tree.
struct SelfSkip {
  std::vector<std::uint8_t> nodes, leaves;  ///< by index: 1 to skip; as many as the tree has

  bool skips(std::int32_t child) const { return (child < 0 ? leaves[~child] : nodes[child]) != 0; }
};

/// Two trees and the views to which they were fitted; `self` if they are the same.
template <BoundingVolume V>
struct TraversalInput {
  const VolumeTree<V>& tree_a;
  const VolumeTree<V>& tree_b;
  const SurfaceView& surface_a;
  const SurfaceView& surface_b;
  bool self;
  const SelfSkip* skip = nullptr;  ///< for self only
  /// Test pairs that merely touch in float again in double. Off in the frame of a rigid body, where
  /// the doubles of the body are rounded differently in each step: such pairs are kept.
  bool settle = true;
};

/// Which of eight volumes overlap a query.
struct Hits {
  unsigned closed;    ///< bit i: the closed volume i overlaps
  unsigned touching;  ///< bit i: volume i merely touches in float
};

inline std::uint64_t key_of(std::int32_t first, std::int32_t second) {
  return static_cast<std::uint64_t>(static_cast<std::uint32_t>(first)) << 32 |
         static_cast<std::uint32_t>(second);
}

/// One traversal kernel, compiled for one vector width.
template <BoundingVolume V>
struct TraversalKernel {
  /// Appends the child pairs of `pair` that overlap; returns false for a pair of leaves.
  bool (*expand)(const TraversalInput<V>& input, TreePair pair, std::vector<TreePair>& out);
  /// Finds all pairs below `pair`; `stack` is scratch.
  void (*traverse)(const TraversalInput<V>& input, TreePair pair, std::vector<TreePair>& stack,
                   FoundPairs& out);
};

/// Two vectors of four with SSE2, plain loops elsewhere. Always available.
template <BoundingVolume V>
TraversalKernel<V> traversal_kernel_narrow();
/// Vectors of eight with AVX2; null pointers if the compiler or the processor does not support it.
template <BoundingVolume V>
TraversalKernel<V> traversal_kernel_wide();

/// Whether the pair overlaps in double precision. Called where the float volumes only touch.
template <int axes>
bool point_triangle_overlap(const SurfaceView& a, std::int32_t point, const SurfaceView& b,
                            std::int32_t triangle);
template <int axes>
bool edge_edge_overlap(const SurfaceView& a, std::int32_t edge_a, const SurfaceView& b,
                       std::int32_t edge_b);

}  // namespace selvedge::detail
