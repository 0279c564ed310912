// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <array>
#include <span>

// Signs and intersection tests that are exact for all finite doubles of any magnitude. A static
// floating-point filter decides the easy cases, integers of arbitrary length the rest. Private to
// the judge.
namespace selvedge::judging {

/// Sign of det[a-d; b-d; c-d]: +1, 0 or -1. Exact.
int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Sign of the signed area of a, b, c, projected along the axis `dropped`. The other two
/// coordinates stay in cyclic order: 0 keeps y z, 1 keeps z x, 2 keeps x y. Exact.
int orient2d(const Vec3& a, const Vec3& b, const Vec3& c, int dropped);

/// True if direction · (q - p) > 0 for every p in `below` and every q in `above`, by more than the
/// rounding error of this computation. A plane then separates the two hulls. False proves nothing.
bool separated_along(const Vec3& direction, std::span<const Vec3> below,
                     std::span<const Vec3> above);

using TrianglePoints = std::array<Vec3, 3>;

/// True if the closed segment p q and the closed triangle have a common point. A degenerate segment
/// or triangle counts as the point or segment that its corners span. Exact.
bool segment_meets_triangle(const Vec3& p, const Vec3& q, const TrianglePoints& triangle);

/// True if the closed segments p q and r s have a common point. Degenerate segments count as above.
/// Exact.
bool segments_meet(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s);

/// True if the closed triangles have a common point. Degenerate triangles count as above. Exact.
bool triangles_meet(const TrianglePoints& a, const TrianglePoints& b);

}  // namespace selvedge::judging
