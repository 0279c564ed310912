// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/tests/bent_surfaces.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

namespace selvedge::testing {
namespace {

constexpr double pi = std::numbers::pi;
constexpr std::int32_t kInner = 3;  // cells from the border

BentSurface half_cylinder() {
  return {.name = "half cylinder",
          .size_u = pi,
          .size_v = pi,
          .integral = pi * pi,
          .at = [](double u, double v) { return Vec3(-std::cos(u), v, std::sin(u)); },
          .squares = [](double, double) { return 1.0; }};
}

/// κ1 = 1/r, κ2 = cos v/(R + r cos v), dA = r (R + r cos v) du dv. With a = R/r,
/// ∫ cos² v/(a + cos v) dv = 2π (a²/√(a² - 1) - a) over a turn.
BentSurface half_torus() {
  constexpr double r = 0.4, a = 1.0 / r;
  return {.name = "half torus",
          .size_u = pi,
          .size_v = 2.0 * pi,
          .cells_u = 1.0,
          .closed = true,
          .integral = 2.0 * pi * pi * a * a / std::sqrt(a * a - 1.0),
          .at =
              [](double u, double v) {
                const double out = 1.0 + r * std::cos(v);
                return Vec3(out * std::cos(u), out * std::sin(u), r * std::sin(v));
              },
          .squares =
              [](double, double v) {
                const double across = std::cos(v) / (1.0 + r * std::cos(v));
                return 1.0 / (r * r) + across * across;
              }};
}

/// κ = ±1/(1 + v²), dA = √(1 + v²) du dv, for v from -1 to 1.
BentSurface helicoid() {
  return {.name = "helicoid",
          .size_u = pi,
          .size_v = 2.0,
          .cells_u = 1.75,
          .integral = 2.0 * pi * std::sqrt(2.0),
          .at = [](double u,
                   double v) { return Vec3((v - 1.0) * std::cos(u), (v - 1.0) * std::sin(u), u); },
          .squares =
              [](double, double v) {
                const double d = 1.0 + (v - 1.0) * (v - 1.0);
                return 2.0 / (d * d);
              }};
}

/// A face of the cube projected on the sphere around it.
BentSurface sphere() {
  return {.name = "sphere",
          .size_u = 0.5 * pi,
          .size_v = 0.5 * pi,
          .integral = 2.0 * 4.0 * pi / 6.0,
          .at =
              [](double u, double v) {
                return Vec3(std::tan(u - 0.25 * pi), std::tan(v - 0.25 * pi), 1.0).normalized();
              },
          .squares = [](double, double) { return 2.0; }};
}

/// A square of side 3 that turns by a right angle on an arc of radius ½ in its middle.
BentSurface creased_sheet() {
  static constexpr double radius = 0.5, arc = 0.5 * pi * radius, begin = 1.5 - 0.5 * arc;
  return {.name = "creased sheet",
          .size_u = 3.0,
          .size_v = 3.0,
          .integral = 3.0 * arc / (radius * radius),
          .at =
              [](double u, double v) {
                if (u < begin) return Vec3(u - begin, v, 0.0);
                if (u > begin + arc) return Vec3(radius, v, radius + u - begin - arc);
                const double turn = (u - begin) / radius;
                return Vec3(radius * std::sin(turn), v, radius * (1.0 - std::cos(turn)));
              },
          .squares =
              [](double u, double) {
                return u < begin || u > begin + arc ? 0.0 : 1.0 / (radius * radius);
              }};
}

}  // namespace

std::vector<BentSurface> bent_surfaces() {
  return {half_cylinder(), half_torus(), helicoid(), sphere(), creased_sheet()};
}

const char* name_of(BendingModel model) {
  switch (model) {
    case BendingModel::hinge:
      return "hinge";
    case BendingModel::bridson:
      return "bridson";
    case BendingModel::shape_operator:
      return "shape_operator";
    case BendingModel::morley:
      break;
  }
  return "Morley";
}

BentMesh divide(const BentSurface& surface, Pattern pattern, std::int32_t cells) {
  const auto nu = static_cast<std::int32_t>(std::lround(surface.cells_u * cells)), nv = cells;
  const std::int32_t rows = surface.closed ? nv : nv + 1;
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> off(-0.25, 0.25);
  BentMesh bent;
  for (std::int32_t j = 0; j < rows; ++j)
    for (std::int32_t i = 0; i <= nu; ++i) {
      const bool moves =
          pattern == Pattern::irregular && i > 0 && i < nu && (surface.closed || (j > 0 && j < nv));
      const double du = off(generator), dv = off(generator);
      const double u = surface.size_u * (i + (moves ? du : 0.0)) / nu;
      const double v = surface.size_v * (j + (moves ? dv : 0.0)) / nv;
      bent.place.push_back({u, v});
      bent.mesh.vertices.push_back(surface.at(u, v));
    }
  for (std::int32_t j = 0; j < nv; ++j)
    for (std::int32_t i = 0; i < nu; ++i) {
      const std::int32_t above = (j + 1) % rows * (nu + 1) + i, a = j * (nu + 1) + i;
      const std::array<std::int32_t, 4> q{a, a + 1, above + 1, above};
      const bool rises =
          pattern == Pattern::one_way ||
          (pattern == Pattern::alternating ? (i + j) % 2 == 0 : generator() % 2 == 0);
      const std::int32_t s = rises ? 0 : 1;
      for (const Triangle& t :
           {Triangle{q[s], q[s + 1], q[s + 2]}, Triangle{q[s], q[s + 2], q[(s + 3) % 4]}}) {
        bent.mesh.triangles.push_back(t);
        std::array<double, 2> middle{0.0, 0.0};
        for (const std::int32_t k : t) {
          const bool wraps = k < a - 1;  // in the first row again
          middle[0] += bent.place[k][0] / 3.0;
          middle[1] += (bent.place[k][1] + (wraps ? surface.size_v : 0.0)) / 3.0;
        }
        bent.middle.push_back(middle);
        const std::int32_t along = std::min(i, nu - 1 - i), across = std::min(j, nv - 1 - j);
        bent.depth.push_back(surface.closed ? along : std::min(along, across));
      }
    }
  return bent;
}

ClothMesh flat_hinged(const BentMesh& bent, BendingModel model) {
  Material m;
  m.bending_stiffness = m.bending_friction = 1.0;
  m.bending_law = "shape_operator";
  if (model == BendingModel::hinge) m.bending_law = "hinge";
  if (model == BendingModel::bridson) m.bending_law = "bridson";
  if (model != BendingModel::shape_operator) m.bending_friction = 0.0;
  ClothMesh cloth = make_from_mesh(bent.mesh, bent.mesh, m);
  for (Hinge& h : cloth.hinges) h.rest_angle = 0.0;
  return cloth;
}

namespace {

double angle_of(const std::vector<Vec3>& x, const std::array<std::int32_t, 4>& v) {
  const Vec3 e = x[v[3]] - x[v[2]];
  const Vec3 n1 = (x[v[0]] - x[v[2]]).cross(x[v[0]] - x[v[3]]);
  const Vec3 n2 = (x[v[1]] - x[v[3]]).cross(x[v[1]] - x[v[2]]);
  return std::atan2(n2.cross(n1).dot(e) / e.norm(), n1.dot(n2));
}

/// The two triangles of each hinge.
std::vector<std::array<std::int32_t, 2>> triangles_of(const ClothMesh& cloth) {
  std::map<Triangle, std::int32_t> number;
  const auto sorted = [](Triangle t) {
    std::sort(t.begin(), t.end());
    return t;
  };
  for (std::size_t i = 0; i < cloth.surface.triangles.size(); ++i)
    number[sorted(cloth.surface.triangles[i])] = static_cast<std::int32_t>(i);
  std::vector<std::array<std::int32_t, 2>> of;
  for (const Hinge& h : cloth.hinges)
    of.push_back(
        {number.at(sorted({h.v[0], h.v[2], h.v[3]})), number.at(sorted({h.v[1], h.v[2], h.v[3]}))});
  return of;
}

/// Twice the energy over B: of the whole mesh, and of the parts of its elements in triangles.
struct Energies {
  double whole = 0.0;
  std::vector<double> of_triangle;
};

/// A hinge divides its energy between its triangles by area.
Energies hinges_of(const ClothMesh& cloth, const std::vector<double>& area) {
  Energies e{0.0, std::vector<double>(area.size(), 0.0)};
  const auto triangles = triangles_of(cloth);
  for (std::size_t i = 0; i < cloth.hinges.size(); ++i) {
    const Hinge& h = cloth.hinges[i];
    const double angle = angle_of(cloth.surface.vertices, h.v);
    const double twice =
        h.sine ? h.stiffness * 8.0 * (1.0 - std::cos(0.5 * angle)) : h.stiffness * angle * angle;
    const auto [a, b] = triangles[i];
    e.whole += twice;
    e.of_triangle[a] += twice * area[a] / (area[a] + area[b]);
    e.of_triangle[b] += twice * area[b] / (area[a] + area[b]);
  }
  return e;
}

/// The friction of the plate has the curvature of each triangle, linear in the angles.
Energies shape_operators_of(const ClothMesh& cloth, const std::vector<double>& area) {
  Energies e{0.0, std::vector<double>(area.size(), 0.0)};
  const std::vector<Vec3>& x = cloth.surface.vertices;
  for (std::size_t t = 0; t < cloth.curvature_frictions.size(); ++t) {
    Vec3 curvature = Vec3::Zero();
    for (const auto& term : cloth.curvature_frictions[t].terms)
      curvature += angle_of(x, cloth.hinges[term.hinge].v) * term.curvature;
    e.of_triangle[t] = area[t] * curvature.squaredNorm();
  }
  const std::vector<Vec3> still(x.size(), Vec3::Zero());
  e.whole = 2.0 * make_shape_operator_force(cloth.hinges, cloth.couples, x.size())
                      ->energy({x, still, cloth.mass, 0.0});
  return e;
}

/// The plate of Morley's triangles. The side e of a triangle has an unknown rotation r_e, by which
/// its normal differs from the mean of those of its two triangles: the triangle's own normal turns
/// by θ_e/2 ± r_e towards it. The curvature of a triangle is (1/A) Σ l n⊗n times these angles.
class MorleyPlate {
 public:
  MorleyPlate(const ClothMesh& cloth, const std::vector<double>& area)
      : cloth_(cloth),
        area_(area),
        angle_(cloth.edges.size(), 0.0),
        first_(cloth.edges.size(), -1) {
    for (std::size_t i = 0; i < cloth.edges.size(); ++i)
      number_[cloth.edges[i]] = static_cast<std::int32_t>(i);
    const auto triangles = triangles_of(cloth);
    for (std::size_t i = 0; i < cloth.hinges.size(); ++i) {
      const Hinge& h = cloth.hinges[i];
      const std::int32_t e = edge(h.v[2], h.v[3]);
      angle_[e] = angle_of(cloth.surface.vertices, h.v);
      first_[e] = triangles[i][0];
    }
  }

  Energies energies() const {
    const auto n = static_cast<Eigen::Index>(angle_.size());
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
    for (std::size_t t = 0; t < area_.size(); ++t) {
      const Side side = sides_of(t);
      for (int i = 0; i < 3; ++i) {
        b[side.edge[i]] -= area_[t] * side.sign[i] * side.unit[i].dot(side.start);
        for (int j = 0; j < 3; ++j)
          entries.emplace_back(
              side.edge[i], side.edge[j],
              area_[t] * side.sign[i] * side.sign[j] * side.unit[i].dot(side.unit[j]));
      }
    }
    Eigen::SparseMatrix<double> a(n, n);
    a.setFromTriplets(entries.begin(), entries.end());
    const Eigen::VectorXd r = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(a).solve(b);
    Energies e{0.0, std::vector<double>(area_.size(), 0.0)};
    for (std::size_t t = 0; t < area_.size(); ++t) {
      const Side side = sides_of(t);
      Vec3 curvature = side.start;
      for (int i = 0; i < 3; ++i) curvature += side.sign[i] * r[side.edge[i]] * side.unit[i];
      e.of_triangle[t] = area_[t] * curvature.squaredNorm();
      e.whole += e.of_triangle[t];
    }
    return e;
  }

 private:
  struct Side {
    std::array<std::int32_t, 3> edge;
    std::array<Vec3, 3> unit;  ///< curvature (11, 22, √2 12) per radian at each side
    std::array<double, 3> sign;
    Vec3 start = Vec3::Zero();  ///< curvature without rotations
  };

  std::int32_t edge(std::int32_t a, std::int32_t b) const {
    return number_.at({std::min(a, b), std::max(a, b)});
  }

  Side sides_of(std::size_t t) const {
    const Triangle& v = cloth_.surface.triangles[t];
    const auto& x = cloth_.surface.vertices;
    const Vec3 normal = (x[v[1]] - x[v[0]]).cross(x[v[2]] - x[v[0]]).normalized();
    const Vec3 e1 = (x[v[1]] - x[v[0]]).normalized(), e2 = normal.cross(e1);
    Side side;
    for (int i = 0; i < 3; ++i) {
      const Vec3 along = x[v[(i + 1) % 3]] - x[v[i]];
      const Vec3 out = along.cross(normal);  // as long as the side
      const double n1 = out.dot(e1), n2 = out.dot(e2), per = 1.0 / (out.norm() * area_[t]);
      side.edge[i] = edge(v[i], v[(i + 1) % 3]);
      side.unit[i] = per * Vec3(n1 * n1, n2 * n2, std::sqrt(2.0) * n1 * n2);
      const std::int32_t e = side.edge[i];
      side.sign[i] = first_[e] < 0 || first_[e] == static_cast<std::int32_t>(t) ? 1.0 : -1.0;
      side.start += 0.5 * angle_[e] * side.unit[i];
    }
    return side;
  }

  const ClothMesh& cloth_;
  const std::vector<double>& area_;
  std::map<Edge, std::int32_t> number_;
  std::vector<double> angle_;        // of each edge; 0 on the border
  std::vector<std::int32_t> first_;  // the triangle with the sign +; -1 on the border
};

std::vector<double> areas_of(const TriangleMesh& mesh) {
  std::vector<double> area;
  const auto& x = mesh.vertices;
  for (const Triangle& t : mesh.triangles)
    area.push_back(0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).norm());
  return area;
}

Energies energies_of(const ClothMesh& cloth, const std::vector<double>& area, BendingModel model) {
  if (model == BendingModel::shape_operator) return shape_operators_of(cloth, area);
  if (model == BendingModel::morley) return MorleyPlate(cloth, area).energies();
  return hinges_of(cloth, area);
}

}  // namespace

double energy_of(const BentMesh& bent, BendingModel model) {
  const std::vector<double> area = areas_of(bent.mesh);
  return 0.5 * energies_of(flat_hinged(bent, model), area, model).whole;
}

EnergyRatio energy_ratio(const BentSurface& surface, const BentMesh& bent, BendingModel model) {
  const std::vector<double> area = areas_of(bent.mesh);
  const Energies e = energies_of(flat_hinged(bent, model), area, model);
  double inner = 0.0, exact = 0.0;
  for (std::size_t t = 0; t < area.size(); ++t) {
    if (bent.depth[t] < kInner) continue;
    inner += e.of_triangle[t];
    exact += area[t] * surface.squares(bent.middle[t][0], bent.middle[t][1]);
  }
  return {e.whole / surface.integral, inner / exact};
}

}  // namespace selvedge::testing
