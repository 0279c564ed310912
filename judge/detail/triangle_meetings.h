// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>
#include <selvedge/judge/detail/exact_predicates.h>

#include <cstdint>
#include <span>

namespace selvedge::judging {

/// How two triangles meet, as Verdict defines it. Triangles that abut touch in one point that is a
/// corner of both, or along one edge that is an edge of both.
enum class Meeting : std::uint8_t { apart, abut, touch, cross };

/// True if the triangles cross: if their insides have a common point, or if the inside of a segment
/// that a degenerate triangle spans passes through the inside of the other triangle. Exact.
bool triangles_cross(const TrianglePoints& a, const TrianglePoints& b);

/// For triangles without a common vertex. Exact, but `touch` may stand for `abut`.
Meeting meeting_of(const TrianglePoints& a, const TrianglePoints& b);

/// For a triangle v w apex that touches t: the side of t, 1 or -1, on which it leans with its edge
/// v w, part of which lies in the inside of t; 0 if it does not. Exact.
int leaning_side(const TrianglePoints& t, const Vec3& v, const Vec3& w, const Vec3& apex);

/// For triangles s and t of one surface with a common vertex (by index), beyond what they have in
/// common: never `abut`. Exact.
Meeting meeting_of_neighbours(std::span<const Vec3> x, const Triangle& s, const Triangle& t);

}  // namespace selvedge::judging
