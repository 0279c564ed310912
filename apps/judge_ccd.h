// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/types.h>

#include <optional>
#include <span>

namespace selvedge {

enum class PathKind {
  point_triangle,  ///< p, then the triangle's corners a b c
  edge_edge,       ///< the first edge's ends a0 a1, then the second's b0 b1
};

/// True if and only if the two closed primitives have a common point at some time t in [0,1], while
/// every vertex moves on the straight line from its place at t = 0 (points 0 to 3) to that at t = 1
/// (points 4 to 7). Touching counts, degenerate primitives and motions are legal, every finite
/// double is. Decided in integers of any length behind proven floating-point filters; shares no
/// code with a narrow phase and serves as their oracle.
bool paths_touch(PathKind kind, std::span<const Vec3, 8> points);

/// The same without the filters.
bool paths_touch_unfiltered(PathKind kind, std::span<const Vec3, 8> points);

/// The earliest time at which they touch: lo is the largest double not later, hi the smallest one
/// not earlier, so that lo == hi exactly if the time is a double. The time is an algebraic number;
/// its enclosure is decided in integers.
struct TouchTime {
  double lo, hi;
};

/// Empty if the primitives never touch.
std::optional<TouchTime> first_touch(PathKind kind, std::span<const Vec3, 8> points);

/// The same without the filters.
std::optional<TouchTime> first_touch_unfiltered(PathKind kind, std::span<const Vec3, 8> points);

}  // namespace selvedge
