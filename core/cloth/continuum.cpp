// SPDX-License-Identifier: MIT
//
// A spring of stiffness k, length L and direction (c,s) stretches by L (c² εx + s² εy + c s γ)
// under a uniform strain, so it adds k L²/A (c², s², cs)(c², s², cs)ᵀ to C. A link rotates by -c s
// εx + c s εy + ½ (c² - s²) γ (without the common rotation). The angle of a torsional spring
// between links of directions u and w changes by the difference of the rotations of its links.
#include <selvedge/core/cloth/detail/grid_mesh.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/measure.h>

#include <Eigen/Geometry>
#include <cmath>

namespace selvedge {
namespace {

Vec3 unit(std::span<const Vec3> rest, std::int32_t a, std::int32_t b) {
  Vec3 d = rest[b] - rest[a];
  d.z() = 0.0;
  return d.normalized();
}

Vec3 turn_of(const Vec3& u) {
  return {-u.x() * u.y(), u.x() * u.y(), 0.5 * (u.x() * u.x() - u.y() * u.y())};
}

Mat3 matrix(const ContinuumConstants& c) {
  Mat3 m;
  m << c.c11, c.c12, c.c13, c.c12, c.c22, c.c23, c.c13, c.c23, c.c33;
  return m;
}

// Strains whose stiffness is below this share of the largest are free.
constexpr double kRankCut = 1e-14;

/// The strain (εx, εy, γ) under a unit stress along x, the least if a strain is free.
Vec3 strain_of_pull(const ContinuumConstants& c) {
  return pseudo_inverse(matrix(c), kRankCut) * Vec3::UnitX();
}

double norm(const ContinuumConstants& c) {
  return std::sqrt(c.c11 * c.c11 + c.c22 * c.c22 + 2.0 * c.c12 * c.c12 +
                   4.0 * (c.c33 * c.c33 + c.c13 * c.c13 + c.c23 * c.c23));
}

}  // namespace

ContinuumConstants continuum_constants(const ClothMesh& cloth, std::span<const Vec3> rest,
                                       double area) {
  require(std::isfinite(area) && area > 0.0, "area", area, "positive and finite");
  Mat3 sum = Mat3::Zero();
  for (const YarnTriangle& t : cloth.yarns) {
    const auto& [p, q, r] = t.rest;
    const double doubled = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    sum += 0.5 * std::abs(doubled) * Vec3(t.warp, t.weft, t.shear).asDiagonal();
  }
  const std::span<const Spring> springs = cloth.springs;
  for (const Spring& s : cloth.yarns.empty() ? springs : springs.first(0)) {
    const Vec3 u = unit(rest, s.a, s.b);
    const Vec3 strain(u.x() * u.x(), u.y() * u.y(), u.x() * u.y());
    sum += (s.stiffness * s.rest_length * s.rest_length) * strain * strain.transpose();
  }
  for (const TwistSpring& t : cloth.twists) {
    const Vec3 turn = turn_of(unit(rest, t.v[1], t.v[2])) - turn_of(unit(rest, t.v[0], t.v[1]));
    sum += t.stiffness * turn * turn.transpose();
  }
  sum /= area;
  return {sum(0, 0), sum(1, 1), sum(0, 1), sum(2, 2), sum(0, 2), sum(1, 2)};
}

double strip_modulus(const ContinuumConstants& c) { return 1.0 / strain_of_pull(c).x(); }

double strip_poisson(const ContinuumConstants& c) {
  const Vec3 strain = strain_of_pull(c);
  return -strain.y() / strain.x();
}

ContinuumConstants membrane_constants(const Material& m, bool flat) {
  const double warp = m.stretch_stiffness, weft = stretch_along_weft(m);
  constexpr double of_spring_nets = 1.0 / 3.0;
  if (!flat) return plate_constants(0.5 * (warp + weft), m.poisson.value_or(of_spring_nets));
  const double shear = shear_law_of(m).add_to_grid != nullptr ? 0.0 : m.shear_stiffness;
  if (!m.poisson) {
    const auto [c11, c22] = detail::stretch_constants(warp, weft, shear);
    return {c11, c22, shear, shear, 0.0, 0.0};
  }
  const double narrowing = 1.0 - *m.poisson * *m.poisson;
  return {warp / narrowing,
          weft / narrowing,
          *m.poisson * std::sqrt(warp * weft) / narrowing,
          shear,
          0.0,
          0.0};
}

ContinuumConstants plate_constants(double stretch, double poisson) {
  const double c11 = stretch / (1.0 - poisson * poisson);
  return {c11, c11, poisson * c11, 0.5 * stretch / (1.0 + poisson), 0.0, 0.0};
}

double relative_distance(const ContinuumConstants& a, const ContinuumConstants& b) {
  return norm({a.c11 - b.c11, a.c22 - b.c22, a.c12 - b.c12, a.c33 - b.c33, a.c13 - b.c13,
               a.c23 - b.c23}) /
         norm(b);
}

double cauchy_residual(const ContinuumConstants& c) {
  ContinuumConstants nearest = c;
  nearest.c12 = nearest.c33 = (c.c12 + 2.0 * c.c33) / 3.0;
  return relative_distance(nearest, c);
}

}  // namespace selvedge
