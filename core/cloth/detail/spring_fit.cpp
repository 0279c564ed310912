// SPDX-License-Identifier: MIT
//
// The spring stiffnesses on the sides of a triangle that are nearest to a sheet's constants; used
// by topology_plate.cpp and, for warp and weft, by add_edge_springs.
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric_laws.h>

#include <Eigen/Geometry>
#include <cmath>

namespace selvedge::detail {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;

/// C11, C22, C12, C33, C13, C23, each times the square root of its multiplicity in the tensor.
Vec6 weighed(const ContinuumConstants& c) {
  const double two = std::sqrt(2.0);
  Vec6 v;
  v << c.c11, c.c22, two * c.c12, 2.0 * c.c33, 2.0 * c.c13, 2.0 * c.c23;
  return v;
}

// Eigenvalues of the normal equations below this share of the largest count as zero.
constexpr double kLeastNormal = 1e-15;

/// The x >= 0 that minimises |m x - y|: the best solution over the eight sets of positive
/// components.
Vec3 positive_least_squares(const Eigen::Matrix<double, 6, 3>& m, const Vec6& y) {
  Vec3 best = Vec3::Zero();
  double least = y.squaredNorm();
  constexpr unsigned sets = 8;
  for (unsigned set = 1; set < sets; ++set) {
    Eigen::Matrix<double, 6, 3> part = m;
    for (int k = 0; k < 3; ++k)
      if (!(set >> k & 1U)) part.col(k).setZero();
    const Mat3 inverse = pseudo_inverse(part.transpose() * part, kLeastNormal);
    Vec3 x = inverse * (part.transpose() * y);
    x += inverse * (part.transpose() * (y - part * x));  // normal equations square the condition
    const double left = (part * x - y).squaredNorm();
    if (x.minCoeff() < 0.0 || left >= least) continue;
    least = left;
    best = x;
  }
  return best;
}

}  // namespace

SpringFit fit_springs(std::span<const Vec3> x, const Triangle& t, const ContinuumConstants& c) {
  SpringFit out{};
  out.area = 0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).norm();
  Eigen::Matrix<double, 6, 3> m;
  for (int k = 0; k < 3; ++k) {
    const Vec3 d = x[t[(k + 1) % 3]] - x[t[k]];
    const double xx = d.x() * d.x(), yy = d.y() * d.y(), xy = d.x() * d.y();
    // k L² (c², s², cs)(...)ᵀ/A, with L² c² = dx²
    const double scale = 1.0 / (out.area * d.squaredNorm());
    m.col(k) = weighed({scale * xx * xx, scale * yy * yy, scale * xx * yy, scale * xy * xy,
                        scale * xx * xy, scale * yy * xy});
  }
  const Vec6 y = weighed(c);
  out.stiffness = positive_least_squares(m, y);
  out.residual = (m * out.stiffness - y).norm() / y.norm();
  return out;
}

}  // namespace selvedge::detail

namespace selvedge {

void register_plate(FabricLaws& laws) {
  laws.forces.add_keyed(
      "plate", "geometry.*.plate",
      {.promise = "springs fitted to a plate; reports the residual of the fit",
       .source =
           "Wang, Devarajan, Improved 2D mass-spring-damper model with unstructured meshes, 2008"});
}

}  // namespace selvedge
