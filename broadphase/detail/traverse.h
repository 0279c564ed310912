// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/bounding_volume_tree.h>
#include <selvedge/broadphase/detail/collect_pairs.h>

#include <vector>

namespace selvedge::detail {

/// A node or leaf of the first tree and one of the second, whose volumes overlap (or, of one tree
/// with itself, may be the same).
struct TreePair {
  std::int32_t a, b;
};

/// Subtrees that need no test against themselves: no two primitives that both belong to triangles
/// below such a node or leaf can touch during the step, but for those that share a vertex. Against
/// the rest of the tree they are tested as ever.
struct SelfSkip {
  std::vector<std::uint8_t> nodes, leaves;  ///< by index: 1 to skip; as many as the tree has

  bool skips(std::int32_t child) const { return (child < 0 ? leaves[~child] : nodes[child]) != 0; }
};

/// Two trees and the views they were fitted to; `self` if they are one and the same.
template <BoundingVolume V>
struct TraversalInput {
  const VolumeTree<V>& tree_a;
  const VolumeTree<V>& tree_b;
  const SurfaceView& surface_a;
  const SurfaceView& surface_b;
  bool self;
  const SelfSkip* skip = nullptr;  ///< for self only
  /// Look again in double at pairs that merely touch in float. Off in the frame of a rigid body,
  /// where the doubles of the body are rounded anew in each step: such pairs are kept.
  bool settle = true;
};

/// Which of eight volumes overlap a query.
struct Hits {
  unsigned closed;    ///< bit i: the closed volume i does
  unsigned touching;  ///< bit i: it does in float, in no more than a touch
};

inline std::uint64_t key_of(std::int32_t first, std::int32_t second) {
  return static_cast<std::uint64_t>(static_cast<std::uint32_t>(first)) << 32 |
         static_cast<std::uint32_t>(second);
}

/// One traversal kernel, compiled for one vector width.
template <BoundingVolume V>
struct TraversalKernel {
  /// Appends the child pairs of `pair` that overlap; false if it is a pair of leaves.
  bool (*expand)(const TraversalInput<V>& input, TreePair pair, std::vector<TreePair>& out);
  /// Finds everything below `pair`; `stack` is scratch.
  void (*traverse)(const TraversalInput<V>& input, TreePair pair, std::vector<TreePair>& stack,
                   FoundPairs& out);
};

/// Two vectors of four where there is SSE2, plain loops elsewhere. Always available.
template <BoundingVolume V>
TraversalKernel<V> traversal_kernel_narrow();
/// Vectors of eight by AVX2; null pointers where the compiler or the processor has none.
template <BoundingVolume V>
TraversalKernel<V> traversal_kernel_wide();

/// Is the pair in double precision really one? Asked where the float volumes only touch.
template <int axes>
bool point_triangle_overlap(const SurfaceView& a, std::int32_t point, const SurfaceView& b,
                            std::int32_t triangle);
template <int axes>
bool edge_edge_overlap(const SurfaceView& a, std::int32_t edge_a, const SurfaceView& b,
                       std::int32_t edge_b);

}  // namespace selvedge::detail
