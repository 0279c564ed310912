// SPDX-License-Identifier: MIT
#include <selvedge/core/block_matrix.h>
#include <selvedge/core/cloth_mesh.h>
#include <selvedge/core/coloring.h>
#include <selvedge/core/detail/dihedral.h>
#include <selvedge/core/force.h>
#include <selvedge/core/integrator.h>
#include <selvedge/core/parallel.h>
#include <selvedge/core/strain_limiter.h>

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cstring>
#include <limits>
#include <numbers>
#include <random>
#include <set>

namespace selvedge {
namespace {

using Vectors = std::vector<Vec3>;

Vectors random_vectors(std::size_t n, double size, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> coordinate(-size, size);
  Vectors out(n);
  for (Vec3& v : out)
    for (int k = 0; k < 3; ++k) v[k] = coordinate(generator);
  return out;
}

Eigen::Map<const Eigen::VectorXd> flat(const Vectors& v) {
  return {v.data()->data(), static_cast<Eigen::Index>(3 * v.size())};
}

/// A crumpled piece of cloth: rest shape plus noise of `noise` metres.
struct Crumple {
  ClothMesh cloth;
  Vectors x, v;
  explicit Crumple(double noise, unsigned seed = 7, double shear = 100.0) {
    Material material;
    material.bending_stiffness = 1e-3;
    material.shear_stiffness = shear;
    cloth = make_rectangular({0.5, 0.4, 5, 4}, material);
    const std::size_t n = cloth.mass.size();
    x = random_vectors(n, noise, seed);
    v = random_vectors(n, 1.0, seed + 1);
    for (std::size_t i = 0; i < n; ++i) x[i] += cloth.surface.vertices[i];
  }
  ForceState state() const { return {x, v, cloth.mass, 0.0}; }
  std::vector<double> areas() const {
    std::vector<double> a;
    for (const Triangle& t : cloth.surface.triangles) {
      const auto& r = cloth.surface.vertices;
      a.push_back(0.5 * (r[t[1]] - r[t[0]]).cross(r[t[2]] - r[t[0]]).norm());
    }
    return a;
  }
};

struct NamedForce {
  std::string name;
  std::unique_ptr<Force> force;
};

ClothMesh with_damping(ClothMesh cloth, double damping) {
  for (Spring& s : cloth.springs) s.damping = damping;
  for (Hinge& h : cloth.hinges) h.damping = damping;
  return cloth;
}

/// Springs and hinges of one, two and three times `damping` by turns.
std::vector<NamedForce> internal_forces(const Crumple& c, double damping) {
  ClothMesh cloth = c.cloth;
  for (std::size_t i = 0; i < cloth.springs.size(); ++i)
    cloth.springs[i].damping = (1.0 + i % 3) * damping;
  for (std::size_t i = 0; i < cloth.hinges.size(); ++i)
    cloth.hinges[i].damping = (1.0 + i % 3) * damping;
  std::vector<NamedForce> forces;
  forces.push_back({"hooke", make_hooke_force(cloth.springs, c.x.size())});
  forces.push_back({"bending", make_bending_force(cloth.hinges, c.x.size())});
  return forces;
}

std::vector<NamedForce> all_forces(const Crumple& c, double damping) {
  std::vector<NamedForce> forces = internal_forces(c, damping);
  forces.push_back({"gravity", make_gravity({1.0, 2.0, -9.81})});
  forces.push_back({"air", make_air_force({{1.0, 2.0, 3.0}, 0.5, 0.2}, c.cloth.surface.triangles,
                                          c.areas(), c.x.size())});
  return forces;
}

Vectors force_at(const Force& force, const ForceState& state) {
  Vectors f(state.x.size(), Vec3::Zero());
  force.add_force(state, f);
  return f;
}

/// The assembled -h ∂F/∂v - h² ∂F/∂x as a dense matrix.
Eigen::MatrixXd dense_jacobian(Force& force, const ForceState& state, double h) {
  const std::size_t n = state.x.size();
  std::vector<Edge> links;
  force.add_links(links);
  BlockMatrix a(n, links);
  force.bind(a);
  force.add_jacobian(state, h, a);
  Eigen::MatrixXd dense(3 * n, 3 * n);
  Vectors e(n, Vec3::Zero()), column(n);
  for (std::size_t k = 0; k < 3 * n; ++k) {
    e[k / 3][k % 3] = 1.0;
    a.multiply(e, column);
    e[k / 3][k % 3] = 0.0;
    dense.col(k) = flat(column);
  }
  return dense;
}

/// ∂F/∂x (or ∂F/∂v) by central differences.
Eigen::MatrixXd difference_jacobian(const Force& force, Crumple c, bool velocity) {
  constexpr double step = 1e-6;
  const std::size_t n = c.x.size();
  Eigen::MatrixXd dense(3 * n, 3 * n);
  Vectors& u = velocity ? c.v : c.x;
  for (std::size_t k = 0; k < 3 * n; ++k) {
    const double old = u[k / 3][k % 3];
    u[k / 3][k % 3] = old + step;
    const Vectors up = force_at(force, c.state());
    u[k / 3][k % 3] = old - step;
    const Vectors down = force_at(force, c.state());
    u[k / 3][k % 3] = old;
    dense.col(k) = (flat(up) - flat(down)) / (2.0 * step);
  }
  return dense;
}

TEST(Forces, AreTheNegativeGradientOfTheirEnergy) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Crumple c(0.03, seed);
    c.v.assign(c.v.size(), Vec3::Zero());
    std::vector<NamedForce> forces = internal_forces(c, 0.02);
    forces.push_back({"gravity", make_gravity({1.0, 2.0, -9.81})});
    for (const auto& [name, force] : forces) {
      const Vectors f = force_at(*force, c.state());
      const double scale = flat(f).cwiseAbs().maxCoeff();
      for (std::size_t k = 0; k < 3 * c.x.size(); ++k) {
        constexpr double step = 1e-6;
        double& u = c.x[k / 3][k % 3];
        const double old = u;
        u = old + step;
        const double up = force->energy(c.state());
        u = old - step;
        const double down = force->energy(c.state());
        u = old;
        EXPECT_NEAR(f[k / 3][k % 3], (down - up) / (2.0 * step), 1e-6 * scale)
            << name << ", seed " << seed;
      }
    }
  }
}

TEST(Forces, AreAffineInTheVelocity) {
  const Crumple c(0.03);
  for (const auto& [name, force] : all_forces(c, 0.02)) {
    Crumple zero = c, twice = c;
    for (std::size_t i = 0; i < c.v.size(); ++i) {
      zero.v[i].setZero();
      twice.v[i] *= 2.0;
    }
    const Vectors f0 = force_at(*force, zero.state()), f1 = force_at(*force, c.state()),
                  f2 = force_at(*force, twice.state());
    const Eigen::VectorXd bend = flat(f2) - 2.0 * flat(f1) + flat(f0);
    EXPECT_LT(bend.norm(), 1e-12 * (1.0 + flat(f2).norm())) << name;
  }
}

TEST(Forces, TheVelocityJacobianIsExact) {
  const Crumple c(0.03);
  for (const auto& [name, force] : all_forces(c, 0.02)) {
    // -h D - h² K at h and 2h give D alone: D = (4 J(h) - J(2h)) / (-2h).
    constexpr double h = 0.01;
    const Eigen::MatrixXd d =
        (4.0 * dense_jacobian(*force, c.state(), h) - dense_jacobian(*force, c.state(), 2.0 * h)) /
        (-2.0 * h);
    const Eigen::MatrixXd exact = difference_jacobian(*force, c, true);
    EXPECT_LT((d - exact).norm(), 1e-7 * (exact.norm() + 1e-12)) << name;
  }
}

TEST(Forces, TheStretchedSpringJacobianIsExact) {
  Crumple c(0.01);
  c.v.assign(c.v.size(), Vec3::Zero());
  for (Vec3& x : c.x) x *= 1.5;  // every spring longer than at rest: nothing is dropped
  const auto force = make_hooke_force(with_damping(c.cloth, 0.0).springs, c.x.size());
  const Eigen::MatrixXd exact = difference_jacobian(*force, c, false);
  EXPECT_LT((dense_jacobian(*force, c.state(), 1.0) + exact).norm(), 1e-7 * exact.norm());
}

TEST(Forces, TheBendingJacobianIsExactAtTheRestAngle) {
  // At θ = θ0 the dropped curvature term is multiplied by zero.
  Crumple c(0.02);
  c.v.assign(c.v.size(), Vec3::Zero());
  for (Hinge& hinge : c.cloth.hinges) hinge.rest_angle = detail::dihedral(c.x, hinge.v).angle;
  const auto force = make_bending_force(with_damping(c.cloth, 0.0).hinges, c.x.size());
  const Eigen::MatrixXd exact = difference_jacobian(*force, c, false);
  EXPECT_LT((dense_jacobian(*force, c.state(), 1.0) + exact).norm(), 1e-6 * exact.norm());
}

TEST(Forces, TheAssembledMatrixIsSymmetricAndPositiveSemidefinite) {
  for (const double noise : {0.0, 0.01, 0.05, 0.2}) {
    const Crumple c(noise);
    for (const auto& [name, force] : all_forces(c, 0.02)) {
      const Eigen::MatrixXd a = dense_jacobian(*force, c.state(), 0.01);
      EXPECT_LE((a - a.transpose()).norm(), 1e-13 * a.norm()) << name;
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a, Eigen::EigenvaluesOnly);
      EXPECT_GE(solver.eigenvalues().minCoeff(), -1e-12 * a.norm()) << name << " " << noise;
    }
  }
}

TEST(Forces, InternalForcesHaveNoSumAndNoMoment) {
  const Crumple c(0.05);
  for (const auto& [name, force] : internal_forces(c, 0.02)) {
    const Vectors f = force_at(*force, c.state());
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    double size = 0.0;
    for (std::size_t i = 0; i < f.size(); ++i) {
      sum += f[i];
      moment += c.x[i].cross(f[i]);
      size += f[i].norm();
    }
    EXPECT_LT(sum.norm(), 1e-12 * size) << name;
    EXPECT_LT(moment.norm(), 1e-12 * size) << name;
  }
}

TEST(Forces, TurnWithTheScene) {
  const Crumple c(0.05);
  const Mat3 q = Eigen::AngleAxisd(1.1, Vec3(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  Crumple turned = c;
  for (std::size_t i = 0; i < c.x.size(); ++i) {
    turned.x[i] = q * c.x[i] + Vec3(3.0, -1.0, 2.0);
    turned.v[i] = q * c.v[i];
  }
  const AirConfig air{{1.0, 2.0, 3.0}, 0.5, 0.2}, turned_air{q * air.wind, 0.5, 0.2};
  auto forces = internal_forces(c, 0.02), turned_forces = internal_forces(c, 0.02);
  forces.push_back({"air", make_air_force(air, c.cloth.surface.triangles, c.areas(), c.x.size())});
  turned_forces.push_back(
      {"air", make_air_force(turned_air, c.cloth.surface.triangles, c.areas(), c.x.size())});
  for (std::size_t k = 0; k < forces.size(); ++k) {
    const Vectors f = force_at(*forces[k].force, c.state());
    const Vectors g = force_at(*turned_forces[k].force, turned.state());
    double error = 0.0;
    for (std::size_t i = 0; i < f.size(); ++i) error = std::max(error, (q * f[i] - g[i]).norm());
    EXPECT_LT(error, 1e-12 * flat(f).norm()) << forces[k].name;
  }
}

TEST(Forces, RigidMotionIsNotDamped) {
  Crumple c(0.05);
  const Vec3 spin(0.3, -2.0, 1.0);
  const ClothMesh cloth = with_damping(c.cloth, 1.0);
  for (std::size_t i = 0; i < c.x.size(); ++i) c.v[i] = Vec3(5.0, 1.0, 2.0) + spin.cross(c.x[i]);
  const Vectors moving = force_at(*make_hooke_force(cloth.springs, c.x.size()), c.state());
  const Vectors bent = force_at(*make_bending_force(cloth.hinges, c.x.size()), c.state());
  c.v.assign(c.v.size(), Vec3::Zero());
  const Vectors still = force_at(*make_hooke_force(cloth.springs, c.x.size()), c.state());
  const Vectors flat_bent = force_at(*make_bending_force(cloth.hinges, c.x.size()), c.state());
  EXPECT_LT((flat(moving) - flat(still)).norm(), 1e-11 * flat(still).norm());
  EXPECT_LT((flat(bent) - flat(flat_bent)).norm(), 1e-11 * flat(flat_bent).norm());
}

TEST(Forces, WindPushesAlongItselfAndNotAClothThatMovesWithIt) {
  Crumple c(0.02);
  const Vec3 wind(0.0, 0.0, 4.0);
  const auto force =
      make_air_force({wind, 0.5, 0.1}, c.cloth.surface.triangles, c.areas(), c.x.size());
  c.v.assign(c.v.size(), Vec3::Zero());
  Vec3 sum = Vec3::Zero();
  for (const Vec3& f : force_at(*force, c.state())) sum += f;
  EXPECT_GT(sum.z(), 0.0);
  c.v.assign(c.v.size(), wind);
  EXPECT_LT(flat(force_at(*force, c.state())).norm(), 1e-14);
}

TEST(Forces, DegenerateShapesGiveFiniteForces) {
  Crumple c(0.0);
  c.x.assign(c.x.size(), Vec3(1.0, 2.0, 3.0));
  for (const auto& [name, force] : all_forces(c, 0.02)) {
    EXPECT_TRUE(flat(force_at(*force, c.state())).allFinite()) << name;
    EXPECT_TRUE(dense_jacobian(*force, c.state(), 0.01).allFinite()) << name;
  }
}

TEST(Forces, BadInputIsRefusedWithItsValue) {
  const std::vector<Spring> outside{{0, 9, 1.0, 1.0}}, no_length{{0, 1, 0.0, 1.0}},
      not_a_number{{0, 1, 1.0, std::nan("")}};
  EXPECT_THROW(make_hooke_force(outside, 2), std::invalid_argument);
  EXPECT_THROW(make_hooke_force(no_length, 2), std::invalid_argument);
  EXPECT_THROW(make_hooke_force(not_a_number, 2), std::invalid_argument);
  const std::vector<Hinge> twice{{{0, 1, 2, 2}, 0.0, 1.0}};
  EXPECT_THROW(make_bending_force(twice, 4), std::invalid_argument);
  EXPECT_THROW(make_gravity({0.0, std::nan(""), 0.0}), std::invalid_argument);
  EXPECT_THROW(make_air_force({Vec3::Zero(), -1.0, 0.0}, {}, {}, 0), std::invalid_argument);
}

template <class Make>
std::string refusal(const Make& make) {
  try {
    make();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Forces, BadDampingIsRefusedWithTheIndexOfItsElement) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {-1.0, inf, -inf, std::nan("")}) {
    const std::vector<Spring> springs{{0, 1, 1.0, 1.0}, {1, 2, 1.0, 1.0, bad}};
    const std::string of_spring = refusal([&] { make_hooke_force(springs, 3); });
    EXPECT_EQ(of_spring.find("damping of spring 1 must be finite and at least 0, not "), 0u)
        << of_spring;
    const std::vector<Hinge> hinges{{{0, 1, 2, 3}, 0.0, 1.0}, {{1, 4, 2, 3}, 0.0, 1.0, bad}};
    const std::string of_hinge = refusal([&] { make_bending_force(hinges, 5); });
    EXPECT_EQ(of_hinge.find("damping of hinge 1 must be finite and at least 0, not "), 0u)
        << of_hinge;
  }
}

TEST(Forces, EverySpringIsDampedByItsOwn) {
  // Two springs at rest length, pulled apart at 2 m/s: only damping acts, k·damping·dL/dt.
  const std::vector<Spring> springs{{0, 1, 1.0, 10.0, 0.1}, {2, 3, 1.0, 10.0, 0.3}};
  const auto force = make_hooke_force(springs, 4);
  const Vectors x{{0, 0, 0}, {1, 0, 0}, {0, 5, 0}, {1, 5, 0}};
  const Vectors v{{0, 0, 0}, {2, 0, 0}, {0, 0, 0}, {2, 0, 0}};
  const std::vector<double> mass(4, 1.0);
  const ForceState state{x, v, mass, 0.0};
  const Vectors f = force_at(*force, state);
  EXPECT_NEAR(f[0].x(), 2.0, 1e-14);
  EXPECT_NEAR(f[2].x(), 6.0, 1e-14);
  std::vector<double> stiffness(4, 0.0), damping(4, 0.0);
  force->add_stiffness_bound(state, stiffness, damping);
  EXPECT_NEAR(damping[1], 2.0, 1e-14);
  EXPECT_NEAR(damping[3], 6.0, 1e-14);
}

TEST(Forces, EveryHingeIsDampedByItsOwn) {
  // A folded hinge and a copy of it far away, both folding at the same rate.
  Vectors x{{0, -1, 0.2}, {0, 1, 0.3}, {-1, 0, 0}, {1, 0, 0}}, v(8, Vec3::Zero());
  for (int k = 0; k < 4; ++k) x.push_back(x[k] + Vec3(0, 0, 16));
  v[0] = v[4] = {0, 0, 1};
  const double angle = detail::dihedral(x, {0, 1, 2, 3}).angle;
  const std::vector<Hinge> hinges{{{0, 1, 2, 3}, angle, 10.0, 0.1},
                                  {{4, 5, 6, 7}, angle, 10.0, 0.3}};
  const auto force = make_bending_force(hinges, 8);
  const std::vector<double> mass(8, 1.0);
  const ForceState state{x, v, mass, 0.0};
  const Vectors f = force_at(*force, state);
  std::vector<double> stiffness(8, 0.0), damping(8, 0.0);
  force->add_stiffness_bound(state, stiffness, damping);
  for (int k = 0; k < 4; ++k) {
    EXPECT_GT(f[k].norm(), 0.1);
    EXPECT_LT((f[k + 4] - 3.0 * f[k]).norm(), 1e-12) << k;
    EXPECT_NEAR(damping[k], 0.1 * stiffness[k], 1e-12) << k;
    EXPECT_NEAR(damping[k + 4], 0.3 * stiffness[k], 1e-12) << k;
  }
}

TEST(ClothMeshes, MassesAddUpToDensityTimesArea) {
  for (const auto make : {make_rectangular, make_triangular}) {
    const ClothMesh cloth = make({0.7, 0.3, 7, 5}, Material{});
    double sum = 0.0;
    for (const double m : cloth.mass) sum += m;
    EXPECT_NEAR(sum, 0.2 * 0.7 * 0.3, 1e-14);
    EXPECT_EQ(cloth.mass.size(), cloth.surface.vertices.size());
    EXPECT_EQ(cloth.strain_limit.size(), cloth.springs.size());
    EXPECT_NO_THROW(validate(cloth.surface, "cloth"));
    EXPECT_EQ(cloth.edges, unique_edges(cloth.surface.triangles));
    for (const Triangle& t : cloth.surface.triangles) {
      const auto& x = cloth.surface.vertices;
      EXPECT_GT((x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).z(), 0.0);
    }
  }
}

TEST(ClothMeshes, TheRectangleHasTheSpringsOfTheSurvey) {
  // 50 × 50 particles: 2N(N-1) structural and 2(N-1)² shear.
  const ClothMesh cloth = make_rectangular({1.0, 1.0, 49, 49}, Material{});
  EXPECT_EQ(cloth.springs.size(), 2u * 50 * 49 + 2u * 49 * 49);
  EXPECT_EQ(cloth.surface.triangles.size(), 2u * 49 * 49);
  // Two for each inner grid edge, one for each cell.
  EXPECT_EQ(cloth.hinges.size(), 2u * 2 * 49 * 48 + 49 * 49);
}

TEST(ClothMeshes, BadConfigurationNamesFieldAndValue) {
  const auto message = [](GridConfig grid, Material material) -> std::string {
    try {
      make_rectangular(grid, material);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  Material material;
  EXPECT_NE(message({1.0, 1.0, 0, 5}, material).find("cells_x"), std::string::npos);
  EXPECT_NE(message({-2.5, 1.0, 5, 5}, material).find("-2.5"), std::string::npos);
  EXPECT_NE(message({1.0, 1.0, 2000000000, 2000000000}, material).find("cells"), std::string::npos);
  material.density = 0.0;
  EXPECT_NE(message({}, material).find("density"), std::string::npos);
  material = {};
  material.stretch_stiffness = std::nan("");
  EXPECT_NE(message({}, material).find("stretch_stiffness"), std::string::npos);
  material = {};
  material.shear_stiffness = 1e6;
  EXPECT_NE(message({1.0, 1.0, 10, 50}, material).find("shear_stiffness"), std::string::npos);
}

TEST(ClothMeshes, BadMeshesAreRefused) {
  TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}}, {{0, 1, 2}}};
  EXPECT_THROW(make_from_mesh(mesh, mesh, Material{}), std::invalid_argument);  // stray vertex
  mesh.vertices.pop_back();
  EXPECT_NO_THROW(make_from_mesh(mesh, mesh, Material{}));
  TriangleMesh line = mesh;
  line.vertices[2] = {2, 0, 0};
  EXPECT_NO_THROW(make_from_mesh(line, mesh, Material{}));
  EXPECT_THROW(make_from_mesh(mesh, line, Material{}), std::invalid_argument);
  TriangleMesh other = mesh;
  other.triangles[0] = {0, 2, 1};
  EXPECT_THROW(make_from_mesh(mesh, other, Material{}), std::invalid_argument);
  EXPECT_THROW(make_from_mesh({}, {}, Material{}), std::invalid_argument);
}

TEST(ClothMeshes, AppendShiftsEveryIndex) {
  ClothMesh all = make_rectangular({1, 1, 2, 2}, Material{});
  const ClothMesh piece = make_triangular({1, 1, 3, 2}, Material{});
  EXPECT_EQ(append(all, piece), 9);
  EXPECT_EQ(all.mass.size(), 9 + piece.mass.size());
  EXPECT_EQ(all.edges, unique_edges(all.surface.triangles));
  const Spring s = all.springs[all.springs.size() - piece.springs.size()];
  EXPECT_EQ(s.a, piece.springs[0].a + 9);
  EXPECT_EQ(all.hinges.back().v[3], piece.hinges.back().v[3] + 9);
}

TEST(ClothMeshes, EveryElementHasTheDampingOfItsFabric) {
  Material material;
  material.spring_damping = 0.02;
  material.bending_damping = 0.03;
  ClothMesh grid = make_rectangular({1, 1, 3, 2}, material);
  ClothMesh triangles = make_triangular({1, 1, 3, 2}, material);
  ClothMesh file = make_from_mesh(grid.surface, grid.surface, material);
  for (ClothMesh* cloth : {&grid, &triangles, &file}) {
    append(*cloth, with_damping(*cloth, 0.5));
    ASSERT_FALSE(cloth->hinges.empty());
    const std::size_t springs = cloth->springs.size(), hinges = cloth->hinges.size();
    for (std::size_t i = 0; i < springs; ++i)
      EXPECT_EQ(cloth->springs[i].damping, i < springs / 2 ? 0.02 : 0.5) << i;
    for (std::size_t i = 0; i < hinges; ++i)
      EXPECT_EQ(cloth->hinges[i].damping, i < hinges / 2 ? 0.03 : 0.5) << i;
  }
}

TEST(ClothMeshes, NonManifoldEdgesHaveNoHinge) {
  TriangleMesh fin{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}},
                   {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}};
  EXPECT_TRUE(make_from_mesh(fin, fin, Material{}).hinges.empty());
}

TEST(Colorings, NoTwoChunksOfAColorShareAParticle) {
  const ClothMesh cloth = make_rectangular({1, 1, 40, 33}, Material{});
  std::vector<std::int32_t> corners;
  for (const Hinge& hinge : cloth.hinges)
    corners.insert(corners.end(), hinge.v.begin(), hinge.v.end());
  const Coloring coloring = color_elements(corners, 4, cloth.mass.size());
  EXPECT_EQ(std::set<std::int32_t>(coloring.order.begin(), coloring.order.end()).size(),
            cloth.hinges.size());
  EXPECT_EQ(coloring.order.size(), cloth.hinges.size());
  EXPECT_GT(cloth.hinges.size(), 5 * color_chunk);
  for (std::size_t c = 0; c + 1 < coloring.color_begin.size(); ++c) {
    std::vector<std::size_t> owner(cloth.mass.size(), SIZE_MAX);
    for (std::size_t i = coloring.color_begin[c]; i < coloring.color_begin[c + 1]; ++i)
      for (int k = 0; k < 4; ++k) {
        const std::size_t chunk = (i - coloring.color_begin[c]) / color_chunk;
        std::size_t& of = owner[corners[4 * coloring.order[i] + k]];
        EXPECT_TRUE(of == SIZE_MAX || of == chunk);
        of = chunk;
      }
  }
}

TEST(BlockMatrices, MultiplyAsTheDenseMatrixDoes) {
  BlockMatrix a(4, {{2, 0}, {0, 2}, {1, 3}});
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(12, 12);
  int count = 0;
  for (const auto& [i, j] :
       std::vector<Edge>{{0, 0}, {0, 2}, {1, 1}, {1, 3}, {2, 0}, {2, 2}, {3, 1}, {3, 3}}) {
    const Mat3 block = Mat3::Constant(++count) + Mat3(Vec3(1, 2, 3).asDiagonal()) * count;
    a.values()[a.slot(i, j)] = block;
    dense.block<3, 3>(3 * i, 3 * j) = block;
  }
  EXPECT_EQ(a.values().size(), 8u);
  EXPECT_THROW(a.slot(0, 1), std::out_of_range);
  EXPECT_THROW(a.slot(4, 0), std::out_of_range);
  EXPECT_THROW(BlockMatrix(2, {{0, 2}}), std::invalid_argument);
  const Vectors x = random_vectors(4, 1.0, 3);
  Vectors y(4);
  a.multiply(x, y);
  EXPECT_LT((dense * flat(x) - flat(y)).norm(), 1e-13);
}

/// Crumpled cloth with one held particle, its forces, and a few terms.
struct ImplicitScene {
  Crumple c{0.02};
  Particles particles;
  std::vector<ImplicitTerm> terms;

  ImplicitScene() {
    particles = {c.x, c.v, c.cloth.mass, {}};
    for (const double m : c.cloth.mass) particles.inv_mass.push_back(1.0 / m);
    particles.inv_mass[3] = 0.0;
    const Vectors n = random_vectors(4, 1.0, 11);
    terms.push_back({{0, 7, 8, 9}, {1.0, -0.2, -0.3, -0.5}, 0.3 * n[0] * n[0].transpose(), n[1]});
    terms.push_back({{5, -1, -1, -1}, {1.0, -0.2, -0.3, -0.5}, Mat3::Identity(), n[2]});
    terms.push_back({{3, 8, -1, -1}, {0.5, -0.5, 0.0, 0.0}, 2.0 * n[3] * n[3].transpose(), n[0]});
  }

  std::unique_ptr<Integrator> integrator(double tolerance = 1e-12) const {
    std::vector<std::unique_ptr<Force>> forces;
    for (auto& named : all_forces(c, 0.02)) forces.push_back(std::move(named.force));
    return make_implicit_euler(std::move(forces), c.x.size(), {.solve = {tolerance, 2000}});
  }
};

TEST(ImplicitEuler, SolvesWhatADenseSolverSolves) {
  ImplicitScene scene;
  constexpr double h = 0.01;
  const std::size_t n = scene.c.x.size();
  Crumple still = scene.c;
  still.v.assign(n, Vec3::Zero());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  Eigen::VectorXd b(3 * n);
  for (std::size_t i = 0; i < n; ++i) {
    a.diagonal().segment<3>(3 * i).setConstant(scene.c.cloth.mass[i]);
    b.segment<3>(3 * i) = scene.c.cloth.mass[i] * scene.c.v[i];
  }
  for (auto& [name, force] : all_forces(scene.c, 0.02)) {
    a += dense_jacobian(*force, scene.c.state(), h);
    b += h * flat(force_at(*force, still.state()));
  }
  for (const ImplicitTerm& t : scene.terms)
    for (int k = 0; k < 4; ++k) {
      if (t.particle[k] < 0) continue;
      b.segment<3>(3 * t.particle[k]) += t.weight[k] * t.rhs;
      for (int l = 0; l < 4; ++l)
        if (t.particle[l] >= 0)
          a.block<3, 3>(3 * t.particle[k], 3 * t.particle[l]) +=
              t.weight[k] * t.weight[l] * t.matrix;
    }
  const Vec3 held(0.1, -0.2, 0.3);
  a.middleRows<3>(9).setZero();
  a.block<3, 3>(9, 9).setIdentity();
  b.segment<3>(9) = held;
  const Eigen::VectorXd exact = a.partialPivLu().solve(b);

  const auto integrator = scene.integrator();
  integrator->begin({scene.particles, 0.0, h}, {});
  Vectors v = scene.c.v;
  v[3] = held;
  const SolveReport report = integrator->solve(scene.terms, {v, {}}, 1.0);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(v[3], held);
  EXPECT_LT((flat(v) - exact).norm(), 1e-9 * exact.norm());
  // Again from the solution: nothing to do. And without terms after terms: as if never given.
  EXPECT_LE(integrator->solve(scene.terms, {v, {}}, 1.0).iterations, 1);
  Vectors plain = scene.c.v, after = scene.c.v;
  integrator->solve({}, {after, {}}, 1.0);
  const auto fresh = scene.integrator();
  fresh->begin({scene.particles, 0.0, h}, {});
  fresh->solve({}, {plain, {}}, 1.0);
  EXPECT_LT((flat(plain) - flat(after)).norm(), 1e-9 * flat(plain).norm());
}

TEST(ImplicitEuler, KeepsTheMomentumOfAFreeCloth) {
  Crumple c(0.05);
  std::vector<std::unique_ptr<Force>> forces;
  for (auto& named : internal_forces(c, 0.02)) forces.push_back(std::move(named.force));
  const auto integrator =
      make_implicit_euler(std::move(forces), c.x.size(), {.solve = {1e-13, 2000}});
  Particles particles{c.x, c.v, c.cloth.mass, {}};
  for (const double m : c.cloth.mass) particles.inv_mass.push_back(1.0 / m);
  const auto momentum = [&] {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < c.x.size(); ++i) sum += particles.mass[i] * particles.v[i];
    return sum;
  };
  const Vec3 before = momentum();
  for (int step = 0; step < 5; ++step) {
    integrator->begin({particles, 0.0, 0.01}, {});
    Vectors v = particles.v;
    integrator->solve({}, {v, {}}, 1.0);
    particles.v = v;
    for (std::size_t i = 0; i < c.x.size(); ++i) particles.x[i] += 0.01 * v[i];
  }
  EXPECT_LT((momentum() - before).norm(), 1e-11);
}

TEST(ImplicitEuler, ANaNIsReportedAndDoesNotHang) {
  ImplicitScene scene;
  scene.particles.x[5].x() = std::nan("");
  const auto integrator = scene.integrator();
  integrator->begin({scene.particles, 0.0, 0.01}, {});
  Vectors v = scene.c.v;
  EXPECT_FALSE(integrator->solve({}, {v, {}}, 1.0).converged);
}

TEST(ImplicitEuler, RefusesTermsOfUnknownParticles) {
  ImplicitScene scene;
  scene.terms[0].particle[2] = 1000;
  const auto integrator = scene.integrator();
  integrator->begin({scene.particles, 0.0, 0.01}, {});
  Vectors v = scene.c.v;
  EXPECT_THROW(integrator->solve(scene.terms, {v, {}}, 1.0), std::invalid_argument);
}

TEST(ImplicitEuler, NeedsFewIterationsOnAFineGrid) {
  // The diagonal alone takes several hundred here; the cycle a number that hardly grows.
  const ClothMesh cloth = make_rectangular({1, 1, 80, 80}, Material{});
  const std::size_t n = cloth.mass.size();
  std::vector<std::unique_ptr<Force>> forces;
  forces.push_back(make_hooke_force(cloth.springs, n));
  forces.push_back(make_bending_force(cloth.hinges, n));
  forces.push_back(make_gravity({0, 0, -9.81}));
  const auto integrator = make_implicit_euler(std::move(forces), n, {});
  Particles p{cloth.surface.vertices, Vectors(n, Vec3::Zero()), cloth.mass, {}};
  for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
  p.inv_mass[0] = p.inv_mass[80] = 0.0;
  for (int step = 0; step < 5; ++step) {
    integrator->begin({p, 0.0, 1.0 / 120.0}, {});
    Vectors v = p.v;
    std::vector<ImplicitTerm> terms;  // stiff contacts with a body
    for (std::int32_t i = 3000; i < 4000; i += 3)
      terms.push_back({{i, -1, -1, -1},
                       {1.0, 0.0, 0.0, 0.0},
                       1e4 * cloth.mass[i] * Mat3::Identity(),
                       Vec3::Zero()});
    const SolveReport report = integrator->solve(terms, {v, {}}, 1.0);
    EXPECT_TRUE(report.converged);
    EXPECT_LT(report.iterations, 40);
    p.v = v;
    for (std::size_t i = 0; i < n; ++i) p.x[i] += v[i] / 120.0;
  }
}

/// Positions after a few steps of a hanging, blown, limited cloth.
Vectors simulate(int threads) {
  const ThreadLimit limit(threads);
  const ClothMesh cloth = make_rectangular({1, 1, 60, 60}, Material{});
  const std::size_t n = cloth.mass.size();
  std::vector<double> areas(cloth.surface.triangles.size(), 0.5 / 3600);
  std::vector<std::unique_ptr<Force>> forces;
  forces.push_back(make_hooke_force(cloth.springs, n));
  forces.push_back(make_bending_force(cloth.hinges, n));
  forces.push_back(make_gravity({0, 0, -9.81}));
  forces.push_back(make_air_force({{1, 0, 2}, 0.5, 0.1}, cloth.surface.triangles, areas, n));
  const auto integrator = make_implicit_euler(std::move(forces), n, {.solve = {1e-4, 1000}});
  const StrainLimiter limiter(cloth.springs, cloth.strain_limit, n);
  Particles p{cloth.surface.vertices, Vectors(n, Vec3::Zero()), cloth.mass, {}};
  for (const double m : cloth.mass) p.inv_mass.push_back(1.0 / m);
  p.inv_mass[0] = p.inv_mass[60] = 0.0;
  for (int step = 0; step < 4; ++step) {
    integrator->begin({p, 0.0, 0.02}, {});
    Vectors v = p.v;
    std::vector<ImplicitTerm> terms;
    for (std::int32_t i = 100; i < 2000; i += 7)
      terms.push_back({{i, i + 1, i + 61, -1},
                       {0.5, 0.3, 0.2, 0.0},
                       Mat3::Identity() * 1e-4,
                       Vec3(0, 0, 1e-5)});
    integrator->solve(terms, {v, {}}, 1.0);
    for (std::size_t i = 0; i < n; ++i) p.x[i] += 0.02 * v[i];
    limiter.apply(p.inv_mass, 1e-3, 20, p.x);
    p.v = v;
  }
  return p.x;
}

TEST(Determinism, OneTwoAndEightThreadsGiveTheSameBits) {
  const Vectors one = simulate(1);
  for (const int threads : {2, 8}) {
    const Vectors many = simulate(threads);
    EXPECT_EQ(std::memcmp(one.data(), many.data(), one.size() * sizeof(Vec3)), 0) << threads;
  }
}

TEST(StrainLimiters, BringEverySpringBelowItsLimitAndKeepMomentum) {
  const ClothMesh cloth = make_rectangular({1, 1, 20, 20}, Material{});
  const StrainLimiter limiter(cloth.springs, cloth.strain_limit, cloth.mass.size());
  Vectors x = random_vectors(cloth.mass.size(), 0.02, 5);
  std::vector<double> inv_mass;
  Vec3 before = Vec3::Zero();
  for (std::size_t i = 0; i < x.size(); ++i) {
    x[i] += cloth.surface.vertices[i];
    inv_mass.push_back(1.0 / cloth.mass[i]);
    before += cloth.mass[i] * x[i];
  }
  EXPECT_GT(limiter.measure(x).max_strain, 0.3);
  const StrainReport report = limiter.apply(inv_mass, 1e-3, 500, x);
  EXPECT_LE(report.residual, 1e-3);
  EXPECT_LE(limiter.measure(x).max_strain, 0.1 + 1e-3);
  EXPECT_GT(report.sweeps, 0);
  Vec3 after = Vec3::Zero();
  for (std::size_t i = 0; i < x.size(); ++i) after += cloth.mass[i] * x[i];
  EXPECT_LT((after - before).norm(), 1e-14);
}

TEST(StrainLimiters, ReportTheResidualWherePinsAreTooFarApart) {
  const std::vector<Spring> springs{{0, 1, 1.0, 1.0}, {1, 2, 1.0, 1.0}};
  const std::vector<double> limits{0.1, 0.1}, inv_mass{0.0, 1.0, 0.0};
  Vectors x{{0, 0, 0}, {1.3, 0, 0}, {2.4, 0, 0}};
  const StrainReport report = StrainLimiter(springs, limits, 3).apply(inv_mass, 1e-3, 50, x);
  EXPECT_EQ(report.sweeps, 50);
  EXPECT_GE(report.residual, 0.1 - 1e-12);
  EXPECT_TRUE(x[1].allFinite());
  EXPECT_EQ(x[0], Vec3(0, 0, 0));
  EXPECT_EQ(x[2], Vec3(2.4, 0, 0));
}

TEST(StrainLimiters, RefuseLimitsThatDoNotFit) {
  const std::vector<Spring> springs{{0, 1, 1.0, 1.0}};
  const std::vector<double> none, negative{-0.1};
  EXPECT_THROW(StrainLimiter(springs, none, 2), std::invalid_argument);
  EXPECT_THROW(StrainLimiter(springs, negative, 2), std::invalid_argument);
}

}  // namespace
}  // namespace selvedge
