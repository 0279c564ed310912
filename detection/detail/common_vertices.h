// SPDX-License-Identifier: MIT
//
// Pairs of triangles with common vertices.
#pragma once

#include <selvedge/core/base/types.h>
#include <selvedge/detection/find.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// Pairs of triangles with at least two common vertices, each once, sorted; and pairs with any
/// common vertex if one of the two names a vertex twice. Linear in the number of triangles for
/// meshes with few triangles at a vertex.
std::vector<TrianglePair> pairs_with_common_edge(std::span<const Triangle> triangles,
                                                 std::size_t vertices);

bool names(const Triangle& t, std::int32_t v);

/// Number of different vertices of s that t names as well.
int common_vertices(const Triangle& s, const Triangle& t);

}  // namespace selvedge::detail
