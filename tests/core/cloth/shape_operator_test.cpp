// SPDX-License-Identifier: MIT
//
// The bending of free triangle meshes: a plate in every direction, whatever the pattern.
#include <selvedge/core/cloth/detail/shape_operator.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/core/solver/integrator.h>
#include <selvedge/tests/dense_algebra.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "rolled_mesh.h"

namespace selvedge::shape_operator_test {
namespace {

constexpr double pi = std::numbers::pi, g = 9.81;
using Vectors = std::vector<Vec3>;

enum class Diagonals { one_way, alternating, random };

/// A rectangle with its corner at the origin; inner vertices moved by up to `shift` cells.
TriangleMesh flat_mesh(int nx, int ny, double cell, Diagonals diagonals, double shift) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> off(-shift * cell, shift * cell);
  TriangleMesh mesh;
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) {
      const bool inner = i > 0 && i < nx && j > 0 && j < ny;
      const double dx = off(generator), dy = off(generator);
      mesh.vertices.emplace_back(i * cell + (inner ? dx : 0.0), j * cell + (inner ? dy : 0.0), 0.0);
    }
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const int a = j * (nx + 1) + i, b = a + 1, c = a + nx + 2, d = a + nx + 1;
      const bool rises =
          diagonals == Diagonals::one_way ||
          (diagonals == Diagonals::alternating ? (i + j) % 2 == 0 : generator() % 2 == 0);
      if (rises) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
      } else {
        mesh.triangles.push_back({a, b, d});
        mesh.triangles.push_back({b, c, d});
      }
    }
  return mesh;
}

/// Moments of all hinges, N·m.
std::vector<double> moments(const ClothMesh& cloth, const Vectors& x) {
  std::vector<double> angle, moment;
  for (const Hinge& h : cloth.hinges) {
    const Vec3 e = x[h.v[3]] - x[h.v[2]];
    const Vec3 n1 = (x[h.v[0]] - x[h.v[2]]).cross(x[h.v[0]] - x[h.v[3]]);
    const Vec3 n2 = (x[h.v[1]] - x[h.v[3]]).cross(x[h.v[1]] - x[h.v[2]]);
    angle.push_back(std::atan2(n2.cross(n1).dot(e) / e.norm(), n1.dot(n2)) - h.rest_angle);
    moment.push_back(h.stiffness * angle.back());
  }
  for (const HingeCouple& c : cloth.couples) {
    moment[c.a] += c.stiffness * angle[c.b];
    moment[c.b] += c.stiffness * angle[c.a];
  }
  return moment;
}

/// Rigidities along warp and weft, N·m.
struct Rigidity {
  double warp, weft;
};

/// What is off, relative to the largest B κ l, in the moments across edges at least `margin` from
/// the border. Bent along n, K = κ n ⊗ n, there is l m·(C K)·m across an edge of normal m, with
/// Poisson's ratio 0 and √(BB') between warp and weft.
double worst_moment(const ClothMesh& cloth, double radius, double angle, const Rigidity& b,
                    double margin) {
  const Vectors& flat = cloth.surface.vertices;
  const std::vector<double> moment = moments(cloth, rolled(flat, radius, angle));
  const double c = std::cos(angle), s = std::sin(angle);
  Vec3 high = flat.front();
  for (const Vec3& p : flat) high = high.cwiseMax(p);
  double worst = 0.0;
  for (std::size_t i = 0; i < cloth.hinges.size(); ++i) {
    const Vec3& from = flat[cloth.hinges[i].v[2]];
    const Vec3& to = flat[cloth.hinges[i].v[3]];
    const Vec3 middle = 0.5 * (from + to), edge = to - from;
    if ((middle.head<2>().array() < margin).any() ||
        ((high - middle).head<2>().array() < margin).any())
      continue;
    const double unit = edge.norm() / radius, mx = edge.y() / edge.norm(),
                 my = -edge.x() / edge.norm();
    const double exact = b.warp * c * c * mx * mx + b.weft * s * s * my * my +
                         2.0 * std::sqrt(b.warp * b.weft) * c * s * mx * my;
    worst = std::max(worst, std::abs(moment[i] / unit - exact) / std::max(b.warp, b.weft));
  }
  return worst;
}

class FreeMesh : public ::testing::TestWithParam<std::tuple<Diagonals, double>> {
 protected:
  TriangleMesh mesh(int nx, int ny, double cell) const {
    return flat_mesh(nx, ny, cell, std::get<0>(GetParam()), std::get<1>(GetParam()));
  }
  static Material material(double rigidity) {
    Material m;
    m.bending_stiffness = rigidity;
    return m;
  }
};

TEST_P(FreeMesh, BentToACylinderEveryEdgeHasThePlatesMoment) {
  constexpr double rigidity = 2e-5, cell = 0.05, radius = 50.0;
  const TriangleMesh flat = mesh(20, 20, cell);
  const ClothMesh cloth = make_from_mesh(flat, flat, material(rigidity));
  for (const double angle : {0.0, pi / 8, pi / 4, pi / 2, 2.0})
    EXPECT_LT(worst_moment(cloth, radius, angle, {rigidity, rigidity}, 3.5 * cell), 0.02) << angle;
}

TEST_P(FreeMesh, BentToACylinderNoInnerVertexFeelsAForce) {
  constexpr double rigidity = 2e-5, cell = 0.05, radius = 1000.0;
  const TriangleMesh flat = mesh(20, 20, cell);
  const auto largest = [&](const std::string& law) {
    Material m = material(rigidity);
    m.bending_law = law;
    const ClothMesh cloth = make_from_mesh(flat, flat, m);
    const Vectors x = rolled(flat.vertices, radius, pi / 8), v(x.size(), Vec3::Zero());
    Vectors f = v;
    ClothMesh bends;
    bends.hinges = cloth.hinges;
    bends.couples = cloth.couples;
    bends.mass = cloth.mass;
    for (const auto& force : make_internal_forces(bends)) force->add_force({x, v, {}, 0.0}, f);
    double most = 0.0;
    for (int j = 6; j <= 14; ++j)
      for (int i = 6; i <= 14; ++i) most = std::max(most, f[j * 21 + i].norm());
    return most / (rigidity / radius);  // in units of B κ
  };
  EXPECT_LT(largest("shape_operator"), 0.02);
  if (std::get<0>(GetParam()) == Diagonals::one_way) return;
  EXPECT_GT(largest("hinge"), 0.2);  // what hinges by themselves leave
}

TEST_P(FreeMesh, NoStateHasANegativeEnergy) {
  const TriangleMesh flat = mesh(5, 4, 0.1);
  const ClothMesh cloth = make_from_mesh(flat, flat, material(1.0));
  const auto n = static_cast<Eigen::Index>(cloth.hinges.size());
  Eigen::MatrixXd w = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) w(i, i) = cloth.hinges[i].stiffness;
  for (const HingeCouple& c : cloth.couples) w(c.a, c.b) = w(c.b, c.a) = c.stiffness;
  EXPECT_GT(selvedge::testing::symmetric_eigenvalues(w).minCoeff(), 0.0);
}

/// A free mesh that is bent step by step, held by its hinges and their friction alone, which only
/// triangles have that are not at the border.
class Bending {
 public:
  Bending(const TriangleMesh& flat, Material m, double friction) : flat_(flat.vertices) {
    m.bending_friction = friction;
    const ClothMesh cloth = make_from_mesh(flat, flat, m);
    Vec3 high = flat_.front();
    for (const Vec3& p : flat_) high = high.cwiseMax(p);
    ClothMesh bends;
    bends.hinges = cloth.hinges;
    bends.couples = cloth.couples;
    bends.mass = cloth.mass;
    for (const CurvatureFriction& f : cloth.curvature_frictions) {
      bool inner = true;
      for (const auto& term : f.terms)
        for (const std::int32_t v : cloth.hinges[term.hinge].v)
          inner = inner && flat_[v].x() > 0.0 && flat_[v].y() > 0.0 && flat_[v].x() < high.x() &&
                  flat_[v].y() < high.y();
      if (!inner) continue;
      bends.curvature_frictions.push_back(f);
      area_ += f.moment / friction;
    }
    forces_ = make_internal_forces(bends);
    x_ = flat_;
    still_.assign(x_.size(), Vec3::Zero());
  }

  double area() const { return area_; }
  double energy() const {
    double sum = 0.0;
    for (const auto& force : forces_) sum += force->energy({x_, still_, {}, 0.0});
    return sum;
  }

  /// Bends to a curvature along `angle` and accepts it; J, what that took.
  double work_to(double curvature, double angle) {
    const Vectors next = curvature == 0.0 ? flat_ : rolled(flat_, 1.0 / curvature, angle);
    const Vectors before = forces_at(x_), after = forces_at(next);
    double work = 0.0;
    for (std::size_t i = 0; i < x_.size(); ++i)
      work -= 0.5 * (before[i] + after[i]).dot(next[i] - x_[i]);
    x_ = next;
    for (const auto& force : forces_) force->accept({x_, still_, {}, 0.0});
    return work;
  }

 private:
  Vectors forces_at(const Vectors& x) const {
    Vectors f = still_;
    for (const auto& force : forces_) force->add_force({x, still_, {}, 0.0}, f);
    return f;
  }

  Vectors flat_, x_, still_;
  std::vector<std::unique_ptr<Force>> forces_;
  double area_ = 0.0;
};

constexpr double friction = 2e-4, yield = 10.0;  // N, 1/m

TEST_P(FreeMesh, ABendingLoopHasTheAreaOfItsFrictionInEveryDirection) {
  constexpr double most = 250.0;  // 1/m, as KES-FB2 bends to
  constexpr int steps = 150;
  for (const double angle : {0.0, pi / 8, pi / 4, 2.0}) {
    Bending bending(mesh(10, 10, 0.001), material(1e-5), friction);
    ASSERT_GT(bending.area(), 2e-5);
    const auto go = [&](double from, double to) {
      double work = 0.0;
      for (int i = 1; i <= steps; ++i)
        work += bending.work_to(from + (to - from) * i / steps, angle);
      return work;
    };
    go(0.0, most);
    const double work = go(most, -most) + go(-most, most);
    EXPECT_NEAR(work / (4.0 * friction * (most - yield) * bending.area()), 1.0, 0.01) << angle;
  }
}

TEST_P(FreeMesh, BendingToAndFroEnergyIsOnlyLost) {
  Bending bending(mesh(8, 8, 0.001), material(1e-5), friction);
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> to(-100.0, 100.0), turn(0.0, pi);
  double curvature = 0.0, angle = 0.0, lost = 0.0;
  for (int way = 0; way < 30; ++way) {
    constexpr int steps = 60;
    if (way % 3 == 0) angle = turn(generator);  // from where it is flat
    const double from = curvature;
    curvature = way % 3 == 2 ? 0.0 : to(generator);
    for (int i = 1; i <= steps; ++i) {
      const double before = bending.energy();
      const double work = bending.work_to(from + (curvature - from) * i / steps, angle);
      const double loss = work - (bending.energy() - before);
      lost += loss;
      // The work is a trapezoid's, off by its error where the friction begins to slip.
      EXPECT_GT(loss, -2e-3 * friction * bending.area() * yield) << way;
    }
  }
  EXPECT_GT(lost, 100.0 * friction * bending.area() * yield);
}

/// Steps of implicit Euler, which damps, until nothing moves faster than 1e-5 m/s.
Vectors at_rest(std::vector<std::unique_ptr<Force>> forces, const ClothMesh& cloth,
                const std::vector<std::int32_t>& held) {
  const std::size_t n = cloth.mass.size();
  Particles p{cloth.surface.vertices, Vectors(n, Vec3::Zero()), cloth.mass, {}};
  for (const double m : p.mass) p.inv_mass.push_back(1.0 / m);
  for (const std::int32_t i : held) p.inv_mass[i] = 0.0;
  const auto integrator =
      integrators().at("implicit_euler")(std::move(forces), n, ImplicitConfig{1e-8, 5000});
  double fastest = 1.0;
  constexpr double h = 0.02;
  for (int step = 0; step < 2000 && (fastest > 1e-5 || step < 5); ++step) {
    integrator->begin({p, 0.0, h}, {});
    Vectors v = p.v;
    EXPECT_TRUE(integrator->solve({}, {v, {}}, 1.0).converged);
    p.v = v;
    fastest = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      p.x[i] += h * v[i];
      fastest = std::max(fastest, v[i].norm());
    }
  }
  EXPECT_LE(fastest, 1e-5);
  return p.x;
}

/// y/x of the tip of a heavy strip of 20 elements, clamped horizontally, Γ = ρ g L³/B. The clamp
/// stands in the middle of the first column of cells, which is held.
double slope_of(const ClothMesh& cloth, double cell, double long_side) {
  const Vectors& flat = cloth.surface.vertices;
  std::vector<std::int32_t> held;
  for (std::size_t i = 0; i < flat.size(); ++i)
    if (flat[i].x() < 1.01 * cell) held.push_back(static_cast<std::int32_t>(i));
  auto forces = make_internal_forces(cloth);
  forces.push_back(make_gravity({0, 0, -g}));
  const Vectors x = at_rest(std::move(forces), cloth, held);
  Vec3 tip = Vec3::Zero();
  double count = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (flat[i].x() > long_side - 0.01 * cell) {
      tip += x[i];
      count += 1.0;
    }
  tip /= count;
  return -tip.z() / (tip.x() - 0.5 * cell);
}

constexpr int elements = 20, rows = 4;
constexpr double length = 0.1, cell = length / (elements + 0.5);

Material heavy(double gamma) {
  Material m;
  m.stretch_stiffness = 2000.0;
  m.bending_stiffness = m.density * g * length * length * length / gamma;
  return m;
}

// Inner vertices are not moved here: the springs of a distorted mesh are no sheet of constant
// stiffness, and the clamp would not stand in the middle of the first cells.
TEST(Cantilever, OfAnyPatternFollowsTheHeavyElastica) {
  constexpr double gamma = 10.0, slope = 1.06680;
  for (const Diagonals diagonals :
       {Diagonals::one_way, Diagonals::alternating, Diagonals::random}) {
    const TriangleMesh strip = flat_mesh(elements + 1, rows, cell, diagonals, 0.0);
    const ClothMesh cloth = make_from_mesh(strip, strip, heavy(gamma));
    EXPECT_NEAR(slope_of(cloth, cell, (elements + 1) * cell) / slope, 1.0, 0.02)
        << static_cast<int>(diagonals);
  }
}

TEST(Cantilever, OfEquilateralTrianglesFollowsTheHeavyElastica) {
  const double side = cell / std::sqrt(0.75);  // a row of triangles is an element
  TriangleMesh strip =
      make_triangular({rows * side, (elements + 1) * cell, rows, elements + 1}, Material{}).surface;
  for (Vec3& x : strip.vertices)  // along x from the origin, face up
    x = Vec3(x.y() + 0.5 * (elements + 1) * cell, -x.x(), 0.0);
  const ClothMesh cloth = make_from_mesh(strip, strip, heavy(2.0));
  EXPECT_NEAR(slope_of(cloth, cell, (elements + 1) * cell) / 0.24667, 1.0, 0.02);
}

TEST(Cantilever, WithAWideLoopFallsAndStopsWithoutGainingEnergy) {
  const TriangleMesh strip = flat_mesh(elements + 1, rows, cell, Diagonals::random, 0.2);
  Material m = heavy(10.0);
  m.bending_friction = 40.0 * m.bending_stiffness;  // keeps a curvature of 40 1/m
  const ClothMesh cloth = make_from_mesh(strip, strip, m);
  ASSERT_FALSE(cloth.curvature_frictions.empty());
  const std::size_t n = cloth.mass.size();
  Particles p{cloth.surface.vertices, Vectors(n, Vec3::Zero()), cloth.mass, {}};
  for (std::size_t i = 0; i < n; ++i)
    p.inv_mass.push_back(p.x[i].x() < 1.1 * cell ? 0.0 : 1.0 / p.mass[i]);
  const auto forces_of = [&] {
    auto forces = make_internal_forces(cloth);
    forces.push_back(make_gravity({0, 0, -g}));
    return forces;
  };
  ForceSum weighed(forces_of(), n);
  const auto integrator =
      integrators().at("implicit_euler")(forces_of(), n, ImplicitConfig{1e-8, 5000});
  constexpr double h = 0.005;
  double energy = 0.0, scale = 0.0, fastest = 0.0;
  for (int step = 0; step < 400; ++step) {
    integrator->begin({p, 0.0, h}, {});
    Vectors v = p.v;
    ASSERT_TRUE(integrator->solve({}, {v, {}}, 1.0).converged);
    p.v = v;
    fastest = 0.0;
    double now = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      p.x[i] += h * v[i];
      now += 0.5 * p.mass[i] * v[i].squaredNorm();
      fastest = std::max(fastest, v[i].norm());
    }
    const ForceState state{p.x, p.v, p.mass, 0.0};
    integrator->accept(state);
    weighed.accept(state);
    now += weighed.energy(state);
    scale = std::max(scale, std::abs(now));
    if (step > 0) {
      EXPECT_LT(now - energy, 1e-3 * scale) << step;
    }
    energy = now;
  }
  EXPECT_LT(fastest, 0.01);
}

TEST(ShapeOperator, HasTheRigiditiesOfWarpAndWeftAndPeircesBetween) {
  constexpr Rigidity rigidity{4e-5, 1e-5};
  constexpr double size = 0.05, radius = 50.0;
  const TriangleMesh flat = flat_mesh(20, 20, size, Diagonals::random, 0.2);
  Material m;
  m.bending_stiffness = rigidity.warp;
  m.bending_weft = rigidity.weft;
  const ClothMesh cloth = make_from_mesh(flat, flat, m);
  for (const double angle : {0.0, pi / 8, pi / 4, pi / 2, 2.0})
    EXPECT_LT(worst_moment(cloth, radius, angle, rigidity, 3.5 * size), 0.02) << angle;
}

TEST(ShapeOperator, ATriangleTurnedOverChangesNothing) {
  const TriangleMesh flat = flat_mesh(8, 8, 0.1, Diagonals::random, 0.2);
  TriangleMesh turned = flat;
  for (std::size_t t = 0; t < turned.triangles.size(); t += 3)
    std::swap(turned.triangles[t][1], turned.triangles[t][2]);
  const Vectors x = rolled(flat.vertices, 2.0, 0.4), v(x.size(), Vec3::Zero());
  const auto energy = [&](const TriangleMesh& mesh) {
    const ClothMesh cloth = make_from_mesh(mesh, mesh, Material{});
    return make_shape_operator_force(cloth.hinges, cloth.couples, x.size())
        ->energy({x, v, {}, 0.0});
  };
  EXPECT_NEAR(energy(turned) / energy(flat), 1.0, 1e-10);
}

TEST(ShapeOperator, ABallIsAtRestInItsOwnShape) {
  TriangleMesh ball{{{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}}, {}};
  ball.triangles = {{2, 4, 0}, {4, 3, 0}, {3, 5, 0}, {5, 2, 0},
                    {4, 2, 1}, {3, 4, 1}, {5, 3, 1}, {2, 5, 1}};
  const ClothMesh cloth = make_from_mesh(ball, ball, Material{});
  const Vectors v(6, Vec3::Zero());
  Vectors f = v;
  make_shape_operator_force(cloth.hinges, cloth.couples, 6)
      ->add_force({ball.vertices, v, {}, 0.0}, f);
  for (const Vec3& force : f) EXPECT_LT(force.norm(), 1e-18);
}

TEST(ShapeOperator, CouplesOfUnlikeHingesAreRefused) {
  const std::vector<Hinge> hinges{{{0, 1, 2, 3}, 0.0, 1.0, 0.01}, {{1, 4, 2, 3}, 0.0, 1.0, 0.02}};
  const std::vector<HingeCouple> couples{{0, 1, 0.1}}, nowhere{{0, 7, 0.1}};
  EXPECT_THROW(make_shape_operator_force(hinges, couples, 5), std::invalid_argument);
  EXPECT_THROW(make_shape_operator_force(hinges, nowhere, 5), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(Patterns, FreeMesh,
                         ::testing::Values(std::tuple{Diagonals::one_way, 0.0},
                                           std::tuple{Diagonals::alternating, 0.0},
                                           std::tuple{Diagonals::random, 0.0},
                                           std::tuple{Diagonals::random, 0.2}));

}  // namespace
}  // namespace selvedge::shape_operator_test
