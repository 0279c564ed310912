// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <array>

namespace selvedge {

/// Whether two triangles cross: their insides have a common point. An edge of one then passes
/// through the inside of the other, or both lie in one plane and overlap in area. Common corners
/// and edges do not count, because they are not inside. A triangle without area is the segment or
/// point that its corners span; such a segment crosses a triangle if it passes through its inside.
///
/// Exact for all finite doubles.
bool triangles_cross(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b);

/// False if the corners are collinear. Exact for all finite doubles.
bool has_area(const std::array<Vec3, 3>& t);

/// For a triangle v w apex whose edge v w lies in the plane of t and passes along the inside of t:
/// the side of t on which the apex is, 1 or -1. Otherwise 0. A surface passes through t along such
/// an edge if it has triangles with this edge on both sides. Exact for all finite doubles.
int side_of_leaf(const std::array<Vec3, 3>& t, const Vec3& v, const Vec3& w, const Vec3& apex);

/// Proves quickly that the triangles v w a and v w b have only their common edge v w in common.
/// False proves nothing. True for most neighbours of a surface.
bool evidently_open_at_edge(const Vec3& v, const Vec3& w, const Vec3& a, const Vec3& b);

}  // namespace selvedge
