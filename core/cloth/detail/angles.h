// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/base/types.h>

#include <Eigen/Geometry>
#include <span>

namespace selvedge::detail {

/// Angle of two vectors of any length, rad in [0, π]; 0 where one of them is zero.
inline double angle_between(const Vec3& u, const Vec3& v) {
  return elementary::atan2(u.cross(v).norm(), u.dot(v));
}

/// Normal of a triangle, twice as long as its area, m².
inline Vec3 area_vector(std::span<const Vec3> x, const Triangle& t) {
  return (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
}

}  // namespace selvedge::detail
