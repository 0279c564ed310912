// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/base/types.h>

#include <Eigen/Geometry>
#include <array>
#include <span>

namespace selvedge::detail {

/// The angle between the normals of two triangles that share an edge, 0 if they are coplanar, in
/// (-π, π], and its gradient with respect to the four vertices: 0 and 1 are opposite the edge 2-3.
struct Dihedral {
  double angle = 0.0;
  std::array<Vec3, 4> gradient;
  bool valid = false;  ///< false if a triangle has no area, so the angle is undefined
};

inline Dihedral dihedral(const Vec3& x1, const Vec3& x2, const Vec3& x3, const Vec3& x4) {
  Dihedral d;
  const Vec3 e = x4 - x3;
  const Vec3 n1 = (x1 - x3).cross(x1 - x4), n2 = (x2 - x4).cross(x2 - x3);
  const double length = e.norm(), n1_squared = n1.squaredNorm(), n2_squared = n2.squaredNorm();
  // Below this ratio of height to edge a normal consists of rounding error: the cross product of
  // two vectors of length |e| has an error of about 1e-16 |e|².
  constexpr double flattest = 1e-12;
  const double smallest = flattest * flattest * length * length * length * length;
  d.valid = n1_squared > smallest && n2_squared > smallest && length > 0.0;
  if (!d.valid) return d;
  // tan θ = (n2 × n1)·e / (|e| n1·n2)
  d.angle = elementary::atan2(n2.cross(n1).dot(e), length * n1.dot(n2));
  // [Bridson2003] section 4: u1..u4 are the gradient of θ.
  const Vec3 a = n1 / n1_squared, b = n2 / n2_squared;
  d.gradient[0] = length * a;
  d.gradient[1] = length * b;
  d.gradient[3] = -((x1 - x3).dot(e) / length) * a - ((x2 - x3).dot(e) / length) * b;
  // u3 = (x1 - x4)·e/|e| a + (x2 - x4)·e/|e| b equals minus the sum of the others. Computed
  // separately, the sum of all four would be a rounding error that is large for an edge much
  // shorter than its triangles.
  d.gradient[2] = -(d.gradient[0] + d.gradient[1] + d.gradient[3]);
  return d;
}

inline Dihedral dihedral(std::span<const Vec3> x, const std::array<std::int32_t, 4>& v) {
  return dihedral(x[v[0]], x[v[1]], x[v[2]], x[v[3]]);
}

}  // namespace selvedge::detail
