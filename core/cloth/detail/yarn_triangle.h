// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/cloth_elements.h>
#include <selvedge/core/cloth/detail/force_checks.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <span>

namespace selvedge::detail {

/// A YarnTriangle by the columns of its deformation gradient: warp and weft, which are unit vectors
/// at rest, are Σ warp[k]·x(v[k]) and Σ weft[k]·x(v[k]).
struct YarnFrame {
  std::array<std::int32_t, 3> v;
  std::array<double, 3> warp, weft;  ///< 1/m; each sums to 0
  double area;                       ///< m²
};

/// Throws std::invalid_argument if triangle `i` has no area at rest.
inline YarnFrame frame_of(const YarnTriangle& t, std::size_t i) {
  const auto& [p, q, r] = t.rest;
  const double ax = q[0] - p[0], ay = q[1] - p[1], bx = r[0] - p[0], by = r[1] - p[1];
  const double doubled = ax * by - ay * bx;
  require_number_of("area", "yarn triangle", i, 0.5 * std::abs(doubled), false);
  YarnFrame f{t.v, {0.0, by / doubled, -ay / doubled}, {0.0, -bx / doubled, ax / doubled}, 0.0};
  f.warp[0] = -f.warp[1] - f.warp[2];
  f.weft[0] = -f.weft[1] - f.weft[2];
  f.area = 0.5 * std::abs(doubled);
  return f;
}

/// One column of the deformation gradient.
inline Vec3 column_of(const std::array<std::int32_t, 3>& v, const std::array<double, 3>& weight,
                      std::span<const Vec3> x) {
  return weight[1] * (x[v[1]] - x[v[0]]) + weight[2] * (x[v[2]] - x[v[0]]);
}

/// The angle between warp and weft, in [0, π]. It exceeds the shear angle by π/2.
struct YarnAngle {
  double value = 0.0;
  std::array<Vec3, 3> gradient;  ///< 1/m
  std::array<double, 3> turn{};  ///< 1/m, turn of both columns per displacement, at most
  bool valid = false;            ///< false if the columns lie on a line
};

inline YarnAngle angle_of(const YarnFrame& f, std::span<const Vec3> x) {
  YarnAngle a;
  const Vec3 p = column_of(f.v, f.warp, x), q = column_of(f.v, f.weft, x);
  const double lp = p.norm(), lq = q.norm();
  if (lp <= 0.0 || lq <= 0.0) return a;
  const Vec3 u = p / lp, w = q / lq, n = u.cross(w);
  const double sine = n.norm();
  // Below this value the normal of both columns is rounding error.
  constexpr double straight = 1e-12;
  a.value = elementary::atan2(sine, u.dot(w));
  a.valid = sine > straight;
  if (!a.valid) return a;
  const Vec3 normal = n / sine, across_u = normal.cross(u) / lp, across_w = normal.cross(w) / lq;
  for (int k = 0; k < 3; ++k) {
    a.gradient[k] = f.weft[k] * across_w - f.warp[k] * across_u;
    a.turn[k] = std::abs(f.warp[k]) / lp + std::abs(f.weft[k]) / lq;
  }
  return a;
}

}  // namespace selvedge::detail
