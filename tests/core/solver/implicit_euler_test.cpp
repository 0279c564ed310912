// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/solver/detail/piece_momentum.h>
#include <selvedge/core/solver/integrator.h>
#include <selvedge/core/solver/strain_limiter.h>
#include <selvedge/tests/dense_algebra.h>

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <numbers>

#include "crumple.h"

namespace selvedge::implicit_euler_test {
namespace {

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
    return integrators().at("implicit_euler")(std::move(forces), c.x.size(),
                                              ImplicitConfig{tolerance, 2000});
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
    a += assembled(*force, scene.c.state(), h);
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
  const Eigen::VectorXd exact = selvedge::testing::solve_dense(a, b);

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

TEST(ImplicitEuler, KeepsItsVelocitiesIfTermsBalanceWhatItCallsUnbalanced) {
  ImplicitScene scene;
  const auto integrator = scene.integrator();
  integrator->begin({scene.particles, 0.0, 0.01}, {});
  Vectors kept = scene.c.v;
  kept[3] = Vec3(0.1, -0.2, 0.3);  // the held one
  const std::span<const Vec3> unbalanced = integrator->unbalanced(kept);
  ASSERT_EQ(unbalanced.size(), kept.size());
  EXPECT_EQ(unbalanced[3], Vec3::Zero());
  std::vector<ImplicitTerm> balance;
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(kept.size()); ++i)
    balance.push_back({{i, -1, -1, -1}, {1, 0, 0, 0}, Mat3::Zero(), -unbalanced[i]});
  Vectors v(kept.size(), Vec3(1, 2, 3));
  v[3] = kept[3];
  Vectors free = v;
  EXPECT_TRUE(integrator->solve(balance, {v, {}}, 1.0).converged);
  EXPECT_LT((flat(v) - flat(kept)).norm(), 1e-9 * flat(kept).norm());
  integrator->solve({}, {free, {}}, 1.0);
  EXPECT_GT((flat(free) - flat(kept)).norm(), 0.1 * flat(kept).norm());
}

TEST(ImplicitEuler, KeepsTheMomentumOfAFreeCloth) {
  Crumple c(0.05);
  std::vector<std::unique_ptr<Force>> forces;
  for (auto& named : internal_forces(c, 0.02)) forces.push_back(std::move(named.force));
  const auto integrator = integrators().at("implicit_euler")(std::move(forces), c.x.size(),
                                                             ImplicitConfig{1e-13, 2000});
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
  const auto integrator =
      integrators().at("implicit_euler")(std::move(forces), n, ImplicitConfig{});
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

/// A cloth of random velocities, which springs and its weight act on.
struct MovingSheet {
  ClothMesh cloth = make_rectangular({1, 1, 40, 40}, Material{});
  std::size_t n = cloth.mass.size();
  Particles particles{cloth.surface.vertices, random_vectors(n, 1.0, 3), cloth.mass, {}};

  MovingSheet() {
    for (const double m : cloth.mass) particles.inv_mass.push_back(1.0 / m);
  }

  /// An integrator that has begun a step.
  std::unique_ptr<Integrator> begun(const ImplicitConfig& config) const {
    std::vector<std::unique_ptr<Force>> forces;
    forces.push_back(make_hooke_force(cloth.springs, n));
    forces.push_back(make_gravity({0, 0, -9.81}));
    auto integrator = integrators().at("implicit_euler")(std::move(forces), n, config);
    integrator->begin({particles, 0.0, 1.0 / 120.0}, {});
    return integrator;
  }
};

TEST(ImplicitEuler, ALooseSolveComputesItsResidualInItsLastIteration) {
  const MovingSheet sheet;
  const auto solve = [&](int most, double looser) {
    Vectors v = sheet.particles.v;
    return sheet.begun({0.05, most})->solve({}, {v, {}}, looser);
  };
  const int needed = solve(2000, 1.0).iterations;
  ASSERT_GT(needed, 0);
  const SolveReport strict = solve(needed, 1.0), loose = solve(needed, 1.0 + 1e-9);
  EXPECT_TRUE(loose.converged);
  EXPECT_EQ(loose.iterations, needed);
  EXPECT_EQ(loose.residual, strict.residual);
  // Both multiply by the matrix in double precision at the end, which these bytes show.
  EXPECT_EQ(loose.bytes, strict.bytes);
}

TEST(ImplicitEuler, VelocitiesOnTheLastLineNeedNoMatrixProduct) {
  const MovingSheet sheet;
  constexpr double tolerance = 1e-6;
  // The report of a solve that begins after a solve, at this share of its way and `off` m/s beside
  // it, and has nothing to do.
  const auto again = [&](double share, double off) {
    const auto integrator = sheet.begun({tolerance, 2000});
    Vectors v = sheet.particles.v;
    EXPECT_TRUE(integrator->solve({}, {v, {}}, 1.0).converged);
    for (std::size_t i = 0; i < sheet.n; ++i)
      v[i] = sheet.particles.v[i] + share * (v[i] - sheet.particles.v[i]);
    v[sheet.n / 2].y() += off;
    const SolveReport report = integrator->solve({}, {v, {}}, 2.0 / tolerance);
    EXPECT_EQ(report.iterations, 0);
    return report;
  };
  const double start = again(0.0, 0.0).residual;
  for (const double share : {0.1, 0.3, 0.7}) {
    const SolveReport on = again(share, 0.0), beside = again(share, 1e-9);
    EXPECT_LT(on.bytes, beside.bytes) << share;
    // The residual decreases linearly along the way, to nearly zero.
    EXPECT_NEAR(on.residual, (1.0 - share) * start, 2.0 * tolerance) << share;
    EXPECT_NEAR(on.residual, beside.residual, 1e-6 * on.residual) << share;
  }
}

TEST(ImplicitEuler, AGuessWhoseResidualOverflowsChangesNothing) {
  const MovingSheet sheet;
  Vectors ends[2];
  for (const double factor : {1.0, 1e200}) {
    Vectors& v = ends[factor > 1.0];
    v = sheet.particles.v;
    for (Vec3& velocity : v) velocity *= factor;
    EXPECT_TRUE(sheet.begun({1e-6, 2000})->solve({}, {v, {}}, 1.0).converged);
  }
  EXPECT_TRUE(ends[0] == ends[1]);
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
  const auto integrator =
      integrators().at("implicit_euler")(std::move(forces), n, ImplicitConfig{1e-4, 1000});
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

/// Strips of particles, each a piece, and a residual that adds up to nothing in all of them.
struct Strips {
  std::size_t pieces, length;
  detail::PieceMomentum momentum;
  Vectors residual, v, v_old, outside;
  std::vector<double> mass;
  std::vector<char> free;

  Strips(std::size_t count, std::size_t particles)
      : pieces(count),
        length(particles),
        momentum(links(count, particles), count * particles),
        residual(count * particles),
        v(residual.size(), Vec3(0.0, 0.0, -1.0)),
        v_old(residual.size(), Vec3::Zero()),
        outside(residual.size(), Vec3::Zero()),
        mass(residual.size(), 1e-4),
        free(residual.size(), 1) {
    for (std::size_t i = 0; i < residual.size(); ++i)
      residual[i] = Vec3(0.0, 0.0, i % 2 == 0 ? 1e-3 : -1e-3);
  }

  static std::vector<Edge> links(std::size_t count, std::size_t particles) {
    std::vector<Edge> all;
    for (std::size_t i = 0; i + 1 < count * particles; ++i)
      if ((i + 1) % particles != 0)
        all.push_back({static_cast<std::int32_t>(i), static_cast<std::int32_t>(i + 1)});
    return all;
  }

  bool kept() { return momentum.kept({residual, v, v_old, mass, outside, free}); }
};

// Few pieces are summed by ranges of particles, many in one range.
TEST(PieceMomentum, IsKeptUnlessOnePieceHasLostAFiftieth) {
  for (const std::size_t pieces : {1, 2, 16, 17, 60}) {
    Strips strips(pieces, 2600);
    EXPECT_EQ(strips.momentum.count(), pieces);
    EXPECT_TRUE(strips.kept()) << pieces;
    // Moved: 2600 particles of 1e-4 kg by 1 m/s. A fiftieth is 5.2e-3 kg·m/s.
    for (const std::size_t piece : {std::size_t{0}, pieces / 2, pieces - 1})
      for (const std::size_t at : {std::size_t{1}, std::size_t{2599}}) {
        Vec3& lost = strips.residual[piece * strips.length + at];
        const Vec3 before = lost;
        lost.x() = 5.1e-3;
        EXPECT_TRUE(strips.kept()) << pieces << ", " << piece;
        lost.x() = 5.3e-3;
        EXPECT_FALSE(strips.kept()) << pieces << ", " << piece;
        strips.free[piece * strips.length + at] = 0;
        strips.free[piece * strips.length + (at ^ 1)] = 0;
        EXPECT_TRUE(strips.kept()) << pieces << ", " << piece << ": held";
        strips.free[piece * strips.length + at] = 1;
        strips.free[piece * strips.length + (at ^ 1)] = 1;
        lost = before;
      }
  }
}

}  // namespace
}  // namespace selvedge::implicit_euler_test
