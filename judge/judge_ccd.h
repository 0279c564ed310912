// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/types.h>

#include <optional>
#include <span>

namespace selvedge {

enum class PathKind {
  point_triangle,  ///< the point p, then the triangle's corners a, b, c
  edge_edge,       ///< the ends a0, a1 of the first edge, then b0, b1 of the second
};

/// True if and only if the two closed primitives have a common point at some time t in [0,1]. Every
/// vertex moves on a straight line: points 0 to 3 are its positions at the start, t = 0, and points
/// 4 to 7 those at the end, t = 1. Touching counts. All finite coordinates are valid, and so are
/// degenerate primitives and motions. Proven floating-point filters decide the easy cases, integers
/// of arbitrary length the rest. The function shares no code with the narrow phases and serves as
/// their oracle.
bool paths_touch(PathKind kind, std::span<const Vec3, 8> points);

/// Like paths_touch, but without the filters.
bool paths_touch_unfiltered(PathKind kind, std::span<const Vec3, 8> points);

/// Earliest time at which the primitives touch. It is an algebraic number, so it is enclosed: lo is
/// the largest double not above it, hi the smallest double not below it, and lo == hi if and only
/// if the time is a double. Integers decide the enclosure.
struct TouchTime {
  double lo, hi;
};

/// Empty if the primitives never touch.
std::optional<TouchTime> first_touch(PathKind kind, std::span<const Vec3, 8> points);

/// Like first_touch, but without the filters.
std::optional<TouchTime> first_touch_unfiltered(PathKind kind, std::span<const Vec3, 8> points);

}  // namespace selvedge
