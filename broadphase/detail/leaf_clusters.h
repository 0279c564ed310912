// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/owned_primitives.h>

namespace selvedge::detail {

/// Triangles in groups that become the leaves of a tree.
struct LeafClusters {
  std::vector<std::int32_t> group;      ///< of each triangle
  std::vector<std::int32_t> triangles;  ///< sorted by group
  std::vector<std::int32_t> begin;      ///< start of each group in `triangles`, and the end

  std::size_t count() const { return begin.size() - 1; }
};

/// Groups of at most `most` triangles connected by edges, from the topology alone: merges
/// neighbouring groups in pairs along the most shared edges, in rounds, by heavy-edge matching
/// [Karypis1998]. Connected triangles stay near each other however the surface deforms, so these
/// groups serve all positions. O((triangles + edges) log most).
LeafClusters cluster_triangles(const OwnedPrimitives& primitives, int most);

}  // namespace selvedge::detail
