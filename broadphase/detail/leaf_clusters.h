// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/owned_primitives.h>

namespace selvedge::detail {

/// Triangles in groups that become the leaves of a tree.
struct LeafClusters {
  std::vector<std::int32_t> group;      ///< of each triangle
  std::vector<std::int32_t> triangles;  ///< those of one group after those of another
  std::vector<std::int32_t> begin;      ///< of each group in `triangles`, plus the total

  std::size_t count() const { return begin.size() - 1; }
};

/// Groups of at most `most` triangles that hang together by edges, by the topology alone:
/// neighbours are merged two by two along the most shared edges, in rounds, by heavy-edge matching
/// [Karypis1998]. Triangles that hang together stay near each other however the surface deforms,
/// so that these groups serve every position. In O((triangles + edges) log most).
LeafClusters cluster_triangles(const OwnedPrimitives& primitives, int most);

}  // namespace selvedge::detail
