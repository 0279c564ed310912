// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

namespace selvedge::detail {

/// How a triangle is deformed: its area in the flat pattern (twice, m²), and the gradient of its
/// place over the pattern.
struct Deformation {
  double area = 0.0;
  Eigen::Matrix<double, 3, 2> gradient;

  double largest_strain() const;  ///< the largest principal one
  Vec3 direction() const;         ///< unit, of that strain in space
};
/// Triangle i of both meshes corresponds.
Deformation deformation(const TriangleMesh& surface, const TriangleMesh& flat,
                        std::size_t triangle);

/// Mean of the largest principal strains within `radius` (m) of a point, by area; 0 without cloth.
double strain_near(const TriangleMesh& surface, const TriangleMesh& flat, const Vec3& point,
                   double radius);

}  // namespace selvedge::detail
