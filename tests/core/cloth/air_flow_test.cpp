// SPDX-License-Identifier: MIT
// The motion of the air: statistics and conservation laws of gusts and jets, and what cloth feels.
#include <gtest/gtest.h>
#include <selvedge/core/cloth/detail/air_flow.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace selvedge::air_flow_test {
namespace {

using detail::AirFlow;

AirConfig gusty(double speed, double length, std::uint64_t seed = 1) {
  AirConfig config;
  config.gusts = {speed, length, seed};
  return config;
}

TEST(Gusts, HaveTheirSpeedInEveryDirectionAndNoMean) {
  Vec3 sum = Vec3::Zero(), squares = Vec3::Zero();
  int n = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const AirFlow flow(gusty(2.0, 0.7, seed));
    for (int i = 0; i < 50; ++i, ++n) {
      const Vec3 u = flow.velocity(Vec3(3.1 * i, -2.3 * i, 1.7 * i), 0.9 * i);
      sum += u;
      squares += u.cwiseAbs2();
    }
  }
  EXPECT_LT((sum / n).norm(), 0.1);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(std::sqrt(squares[k] / n), 2.0, 0.06);
}

// The longitudinal correlation is exp(-π r²/(4 L²)), whose integral over r is L; across the
// velocity it is (1 - π r²/(4 L²)) times as large, as the missing divergence demands.
TEST(Gusts, AreCorrelatedOverTheirLength) {
  const double length = 0.8;
  for (const double r : {0.2, 0.5, 1.0, 1.6}) {
    double along = 0.0, across = 0.0, square = 0.0;
    for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
      const AirFlow flow(gusty(1.0, length, seed));
      for (int i = 0; i < 10; ++i) {
        const Vec3 x(0, 9.0 * i, 0);
        const Vec3 a = flow.velocity(x, 0.0), b = flow.velocity(x + Vec3(r, 0, 0), 0.0);
        along += a.x() * b.x();
        across += a.y() * b.y();
        square += a.x() * a.x();
      }
    }
    const double c = std::numbers::pi * r * r / (4.0 * length * length);
    EXPECT_NEAR(along / square, std::exp(-c), 0.03) << r;
    EXPECT_NEAR(across / square, (1.0 - c) * std::exp(-c), 0.03) << r;
  }
}

TEST(Gusts, HaveNoDivergence) {
  const AirFlow flow(gusty(3.0, 0.5));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> in(-2.0, 2.0);
  double largest = 0.0;
  for (int i = 0; i < 100; ++i) {
    const Vec3 x(in(random), in(random), in(random));
    double divergence = 0.0;
    for (int k = 0; k < 3; ++k) {
      const Vec3 h = 1e-5 * Vec3::Unit(k);
      const Vec3 slope = (flow.velocity(x + h, 0.3) - flow.velocity(x - h, 0.3)) / 2e-5;
      divergence += slope[k];
      largest = std::max(largest, slope.cwiseAbs().maxCoeff());
    }
    EXPECT_NEAR(divergence, 0.0, 1e-7);
  }
  EXPECT_GT(largest, 5.0);
}

TEST(Gusts, TravelWithTheWindAndChangeOnTheWay) {
  AirConfig config = gusty(0.5, 1.0);
  const AirFlow still(config);
  config.wind = Vec3(4, 0, 1);
  const AirFlow carried(config);
  const Vec3 x(0.3, -0.2, 0.9);
  for (const double t : {0.0, 0.4, 2.0})
    EXPECT_LT(
        (carried.velocity(x + t * config.wind, t) - config.wind - still.velocity(x, t)).norm(),
        1e-12);
  EXPECT_GT((still.velocity(x, 4.0) - still.velocity(x, 0.0)).norm(), 0.1);
  EXPECT_NE(AirFlow(gusty(0.5, 1.0, 2)).velocity(x, 0.0), still.velocity(x, 0.0));
}

AirConfig one_jet() {
  AirConfig config;
  config.jets = {
      {.position = Vec3(1, 2, 3), .direction = Vec3(0, 0, 5), .speed = 10.0, .diameter = 0.2}};
  return config;
}

TEST(Jet, KeepsItsMomentumAndDecaysAsMeasured) {
  const AirFlow flow(one_jet());
  const Vec3 nozzle(1, 2, 3);
  const double of_nozzle = std::numbers::pi / 4.0 * 0.2 * 0.2 * 100.0;
  for (const double s : {0.0, 0.5, 1.16, 2.0, 6.0}) {
    double momentum = 0.0;
    const double dr = 1e-3 * (0.2 + s);
    for (double r = 0.5 * dr; r < 5.0 * (0.2 + s); r += dr) {
      const double u = flow.velocity(nozzle + Vec3(r, 0, s), 7.0).z();
      momentum += 2.0 * std::numbers::pi * r * u * u * dr;
    }
    EXPECT_NEAR(momentum / of_nozzle, 1.0, 2e-3) << s;
  }
  // Pope 2000, table 5.1: u0 D/(s u) = 1/5.8, half-width 0.096 s.
  const double middle = flow.velocity(nozzle + Vec3(0, 0, 6), 0.0).z();
  EXPECT_NEAR(10.0 * 0.2 / (6.0 * middle), 1.0 / 5.8, 1e-12);
  EXPECT_NEAR(flow.velocity(nozzle + Vec3(0, 0.096 * 6.0, 6), 0.0).z() / middle, 0.5, 5e-3);
  EXPECT_EQ(flow.velocity(nozzle - Vec3(0, 0, 0.01), 0.0), Vec3::Zero());
  EXPECT_EQ(flow.velocity(nozzle, 0.0), Vec3(0, 0, 10));
}

TEST(AirFlow, BadNumbersAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  AirConfig config = one_jet();
  config.jets[0].direction = Vec3::Zero();
  EXPECT_THROW(AirFlow{config}, std::invalid_argument);
  config = one_jet();
  config.jets[0].diameter = 0.0;
  EXPECT_THROW(AirFlow{config}, std::invalid_argument);
  EXPECT_THROW(AirFlow{gusty(1.0, 0.0)}, std::invalid_argument);
  EXPECT_THROW(AirFlow{gusty(nan, 1.0)}, std::invalid_argument);
  EXPECT_NO_THROW(AirFlow{gusty(0.0, 0.0)});  // the length counts only with gusts
}

TEST(AirForce, IsZeroWhereTheClothMovesWithTheAir) {
  AirConfig config = gusty(1.5, 0.6);
  config.wind = Vec3(1, 0, 0);
  config.jets = one_jet().jets;
  config.normal_drag = 0.5;
  const AirFlow flow(config);
  const std::vector<Triangle> triangles = {{0, 1, 2}};
  const std::vector<double> areas = {0.02};
  const std::vector<Vec3> x = {{1, 2, 4}, {1.2, 2, 4}, {1, 2.2, 4.1}};
  const double time = 0.37;
  std::vector<Vec3> air;
  for (const Vec3& p : x) air.push_back(flow.velocity(p, time));
  const Vec3 u = (air[0] + air[1] + air[2]) / 3.0;
  const auto force = make_air_force(config, triangles, areas, 3);
  const std::vector<double> mass(3, 1.0);
  const Vec3 n = (x[1] - x[0]).cross(x[2] - x[0]).normalized();
  for (const Vec3& v : {u, Vec3(0, 0, 0), Vec3(1, -2, 3)}) {
    const std::vector<Vec3> velocities(3, v);
    std::vector<Vec3> f(3, Vec3::Zero());
    force->add_force({x, velocities, mass, time}, f);
    const Vec3 expected = 0.5 * 0.02 * n.dot(u - v) * n;
    EXPECT_LT((f[0] + f[1] + f[2] - expected).norm(), 1e-15);
  }
  // Particles feel the air at their own place.
  config.normal_drag = 0.0;
  config.viscous_drag = 0.3;
  std::vector<Vec3> f(3, Vec3::Zero());
  make_air_force(config, triangles, areas, 3)
      ->add_force({x, std::vector<Vec3>(3, Vec3::Zero()), mass, time}, f);
  for (int i = 0; i < 3; ++i) EXPECT_LT((f[i] - 0.3 * 0.02 / 3.0 * air[i]).norm(), 1e-15);
}

}  // namespace
}  // namespace selvedge::air_flow_test
