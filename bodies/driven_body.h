// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/body.h>

#include <span>
#include <vector>

namespace selvedge {

/// A body whose vertices a program sets while a simulation runs. It starts at rest, where the body
/// is that it replaces.
class DrivenBody final : public Body {
 public:
  /// Takes the triangles of `start` and its positions at `time`, s.
  explicit DrivenBody(const Body& start, double time = 0.0);

  /// Every vertex moves on a straight line from its position at t0 to x[i] at t1 (m and s), and
  /// then rests. Replaces a motion that has not ended. Throws std::invalid_argument if `x` has
  /// another length than the body, names the first vertex that is not finite, and requires
  /// t0 < t1.
  void move_to(std::span<const Vec3> x, double t0, double t1);
  /// The body rests at x from time t on. Throws as move_to does.
  void place(std::span<const Vec3> x, double t);

  const std::vector<Triangle>& triangles() const override { return triangles_; }
  std::size_t vertex_count() const override { return to_.size(); }
  void positions(double time, std::span<Vec3> x) const override;
  /// True only after the end of the last motion, because a program may still set another motion for
  /// any later time.
  bool is_static(double t0, double t1) const override;

 private:
  void check(std::span<const Vec3> x) const;

  std::vector<Triangle> triangles_;
  std::vector<Vec3> from_, to_;  // m, at t0_ and t1_
  double t0_, t1_;               // s
};

}  // namespace selvedge
