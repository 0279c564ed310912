// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/dress/detail/winding_number.h>

#include <Eigen/Geometry>
#include <numbers>

namespace selvedge::detail {

double winding_number(const TriangleMesh& body, const Vec3& point) {
  double sum = 0.0;
  for (const Triangle& t : body.triangles) {
    const Vec3 a = body.vertices[t[0]] - point, b = body.vertices[t[1]] - point,
               c = body.vertices[t[2]] - point;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    const double below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    sum += 2.0 * elementary::atan2(a.dot(b.cross(c)), below);
  }
  return sum / (4.0 * std::numbers::pi);
}

}  // namespace selvedge::detail
