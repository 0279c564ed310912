// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <array>

namespace selvedge::detail {

using Corners = std::array<Vec3, 3>;

/// True if the corners are collinear. Exact.
bool has_no_area(const Corners& t);

/// True if the closed triangles have a common point; touching counts. Exact for finite
/// corners. A triangle without area counts as its
/// longest edge; two such triangles never meet.
bool triangles_meet(const Corners& a, const Corners& b);

/// For triangles with the common corner a[0] = b[0]: true if they meet anywhere else. False if one
/// has no area. Exact.
bool wedges_meet(const Corners& a, const Corners& b);

/// For triangles with the common corners a[0] = b[0] and a[1] = b[1]: true if they overlap, that
/// is, lie in one plane on the same side of their common edge. Exact.
bool leaves_overlap(const Corners& a, const Corners& b);

}  // namespace selvedge::detail
