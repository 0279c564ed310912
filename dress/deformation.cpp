// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/dress/detail/deformation.h>

#include <Eigen/LU>
#include <cmath>

namespace selvedge::detail {

double Deformation::largest_strain() const {
  const Eigen::Matrix2d c = gradient.transpose() * gradient;
  const double mean = 0.5 * (c(0, 0) + c(1, 1)), half = 0.5 * (c(0, 0) - c(1, 1));
  return std::sqrt(mean + elementary::hypot(half, c(0, 1))) - 1.0;
}

Vec3 Deformation::direction() const {
  const Eigen::Matrix2d c = gradient.transpose() * gradient;
  const double half = 0.5 * elementary::atan2(2.0 * c(0, 1), c(0, 0) - c(1, 1));
  return (gradient * Eigen::Vector2d(elementary::cos(half), elementary::sin(half))).normalized();
}

Deformation deformation(const TriangleMesh& surface, const TriangleMesh& flat,
                        std::size_t triangle) {
  const Triangle &t = surface.triangles[triangle], &f = flat.triangles[triangle];
  Eigen::Matrix2d rest;
  Eigen::Matrix<double, 3, 2> now;
  for (int k = 0; k < 2; ++k) {
    rest.col(k) = (flat.vertices[f[k + 1]] - flat.vertices[f[0]]).head<2>();
    now.col(k) = surface.vertices[t[k + 1]] - surface.vertices[t[0]];
  }
  return {std::abs(rest.determinant()), now * rest.inverse()};
}

double strain_near(const TriangleMesh& surface, const TriangleMesh& flat, const Vec3& point,
                   double radius) {
  double sum = 0.0, area = 0.0;
  for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
    const Triangle& t = surface.triangles[i];
    if ((surface.vertices[t[0]] - point).norm() > radius) continue;
    const Deformation d = deformation(surface, flat, i);
    sum += d.area * d.largest_strain();
    area += d.area;
  }
  return area > 0.0 ? sum / area : 0.0;
}

}  // namespace selvedge::detail
