// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>
#include <selvedge/narrowphase/detail/contact_geometry.h>
#include <selvedge/narrowphase/detail/pair_screen.h>

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace selvedge::narrowphase_detail {

/// The paths of the vertices of two surfaces in single precision, four numbers per register. A
/// cheap test rules out most pairs before the test in double precision. Only what it proves is
/// used, so results do not depend on it. Let M be the largest coordinate. A float differs from its
/// double by at most M 2^-24, a difference or sum of two floats from the exact one by at most M
/// 2^-22, and a difference of two such sums by at most M 2^-20: that is the slack.
class FloatPaths {
 public:
  /// Throws as require_finite. `a` and `b` may be one object.
  FloatPaths(const SurfaceView& a, const SurfaceView& b);

  /// Whether the primitives share no point during the step: along an axis, or along the sum or the
  /// difference of two, all vertices of one lie below those of the other by more than the slack, in
  /// the same order at both ends. Differences are linear in t, so the order holds in between.
  bool never_meet(const PairVertices& pair) const;

  /// The path of vertex k of a pair, as a screen takes it.
  const float* numbers(const PairVertices& pair, int k) const { return path(pair, k).t0.data(); }
  /// Limits of a screen: pairs are far if their distance at t = 0 is more than `reach_at_start`, or
  /// more than `reach` and the largest relative displacement of two vertices together; in metres.
  ScreenLimits limits(double reach, double reach_at_start) const;

 private:
  using Array = Eigen::Array4f;
  struct alignas(32) Path {
    Array t0, t1;  ///< the last component is 0
  };
  struct Boxes;

  static double largest_coordinate(const SurfaceView& view, const char* name);
  static std::vector<Path> convert(const SurfaceView& view, bool proves);
  const Path& path(const PairVertices& pair, int k) const {
    const int side = k < first_count(pair.kind) ? pair.first : pair.second;
    return paths_[side][static_cast<std::size_t>(pair.vertex[k])];
  }

  std::vector<Path> own_a_, own_b_;
  std::array<const Path*, 2> paths_;  ///< of a and b
  float slack_ = 0.0F;                ///< m, of the difference of two coordinates
};

/// Boxes of the two primitives of a pair.
struct FloatPaths::Boxes {
  Array lo_a, hi_a, lo_b, hi_b;

  Boxes(const Array& x0, const Array& x1, const Array& x2, const Array& x3, bool edges)
      : lo_a(x0), hi_a(x0), lo_b(x2.min(x3)), hi_b(x2.max(x3)) {
    if (edges) {
      lo_a = lo_a.min(x1);
      hi_a = hi_a.max(x1);
    } else {
      lo_b = lo_b.min(x1);
      hi_b = hi_b.max(x1);
    }
  }
  /// By axis: room between them if b lies above a, and if it lies below; negative if they overlap.
  Array above() const { return lo_b - hi_a; }
  Array below() const { return lo_a - hi_b; }
};

inline bool FloatPaths::never_meet(const PairVertices& pair) const {
  const bool edges = pair.kind == ContactKind::edge_edge;
  const Path &p0 = path(pair, 0), &p1 = path(pair, 1), &p2 = path(pair, 2), &p3 = path(pair, 3);
  const auto ordered = [&](const auto& direction) {
    const Boxes start(direction(p0.t0), direction(p1.t0), direction(p2.t0), direction(p3.t0),
                      edges);
    const Boxes end(direction(p0.t1), direction(p1.t1), direction(p2.t1), direction(p3.t1), edges);
    const Array room = start.above().min(end.above()).max(start.below().min(end.below()));
    return room.maxCoeff() > slack_;
  };
  // x, y, z; then their sums and differences in turn.
  const auto next = [](const Array& x) { return Array(x[1], x[2], x[0], x[3]); };
  return ordered([](const Array& x) { return x; }) ||
         ordered([&](const Array& x) { return Array(x + next(x)); }) ||
         ordered([&](const Array& x) { return Array(x - next(x)); });
}

}  // namespace selvedge::narrowphase_detail
