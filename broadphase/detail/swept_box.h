// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>

#include <algorithm>

namespace selvedge::detail {

/// Boxes per task: tens of µs of work.
inline constexpr std::size_t kBoxGrain = 4096;

/// A closed axis-aligned box in double precision, metres.
struct DoubleBox {
  std::array<double, 3> lo, hi;
};

/// The box of vertex v over the step, inflated by the surface's thickness.
inline DoubleBox swept_box(const SurfaceView& surface, std::int32_t v) {
  DoubleBox box;
  const Vec3 &x0 = surface.x_t0[v], &x1 = surface.x_t1[v];
  for (int k = 0; k < 3; ++k) {
    box.lo[k] = std::min(x0[k], x1[k]) - surface.thickness;
    box.hi[k] = std::max(x0[k], x1[k]) + surface.thickness;
  }
  return box;
}

/// The smallest box around both.
inline DoubleBox united(const DoubleBox& a, const DoubleBox& b) {
  DoubleBox box;
  for (int k = 0; k < 3; ++k) {
    box.lo[k] = std::min(a.lo[k], b.lo[k]);
    box.hi[k] = std::max(a.hi[k], b.hi[k]);
  }
  return box;
}

/// The box of an edge or a triangle over the step. Rounded subtraction is monotone, so the union of
/// the inflated vertex boxes equals the inflated union, bit for bit.
template <std::size_t n>
DoubleBox swept_box(const SurfaceView& surface, const std::array<std::int32_t, n>& vertices) {
  DoubleBox box = swept_box(surface, vertices[0]);
  for (std::size_t i = 1; i < n; ++i) box = united(box, swept_box(surface, vertices[i]));
  return box;
}

inline bool overlap(const DoubleBox& a, const DoubleBox& b) {
  return (a.lo[0] <= b.hi[0]) & (b.lo[0] <= a.hi[0]) & (a.lo[1] <= b.hi[1]) & (b.lo[1] <= a.hi[1]) &
         (a.lo[2] <= b.hi[2]) & (b.lo[2] <= a.hi[2]);
}

inline bool contains(const Triangle& t, std::int32_t v) {
  return t[0] == v || t[1] == v || t[2] == v;
}

inline bool share_vertex(const Edge& a, const Edge& b) {
  return a[0] == b[0] || a[0] == b[1] || a[1] == b[0] || a[1] == b[1];
}

}  // namespace selvedge::detail
