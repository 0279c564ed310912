// SPDX-License-Identifier: MIT
//
// The strain limiter of triangles, against strains that are computed here from a grid.
#include <gtest/gtest.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/core/solver/strain_limiter.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <random>

#include "crumple.h"

namespace selvedge::continuum_limiter_test {
namespace {

constexpr double kLimit = 0.1, kTolerance = 1e-3;

std::unique_ptr<StrainLimitMethod> continuum(std::span<const Spring> springs,
                                             std::span<const double> limits, std::size_t particles,
                                             bool compression = false) {
  return strain_limiters()
      .at("continuum")({{"compression", compression ? 1.0 : 0.0}}, springs, limits, particles)
      .method;
}

/// Largest |f1| - 1 and |f2| - 1, and largest |f1·f2|/2, of the four triangles of each cell.
struct GridStrain {
  double stretch = -1.0, compression = -1.0, shear = 0.0;

  GridStrain(std::span<const Vec3> x, int cells, double side) {
    const int row = cells + 1;
    for (int j = 0; j < cells; ++j)
      for (int i = 0; i < cells; ++i) {
        const std::array<Vec3, 4> p{x[j * row + i], x[j * row + i + 1], x[(j + 1) * row + i],
                                    x[(j + 1) * row + i + 1]};
        const std::array<Vec3, 2> warp{(p[1] - p[0]) / side, (p[3] - p[2]) / side};
        const std::array<Vec3, 2> weft{(p[2] - p[0]) / side, (p[3] - p[1]) / side};
        for (const Vec3& f : {warp[0], warp[1], weft[0], weft[1]}) {
          stretch = std::max(stretch, f.norm() - 1.0);
          compression = std::max(compression, 1.0 - f.norm());
        }
        for (const Vec3& f : warp)
          for (const Vec3& g : weft) shear = std::max(shear, std::abs(0.5 * f.dot(g)));
      }
  }
};

/// A square net pulled out and sheared at random, in a step of 10 ms.
struct Pulled {
  static constexpr int cells = 10;
  ClothMesh cloth = make_rectangular({1.0, 1.0, cells, cells}, Material{});
  std::vector<double> limits = std::vector<double>(cloth.springs.size(), kLimit);
  std::vector<double> inv_mass;
  Vectors x_t0, x;

  explicit Pulled(unsigned seed, double stretch = 1.08, double shear = 0.3, double noise = 0.03) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    for (const double m : cloth.mass) inv_mass.push_back(1.0 / m);
    x_t0 = cloth.surface.vertices;
    for (const Vec3& p : x_t0)
      x.push_back(stretch * p + Vec3(shear * p.y(), 0, 0) +
                  noise * Vec3(unit(random), unit(random), unit(random)));
  }
  std::unique_ptr<StrainLimitMethod> method() const {
    return continuum(cloth.springs, limits, x.size());
  }
  LimitStep step(int sweeps = 5000) const { return {x_t0, inv_mass, 0.01, kTolerance, sweeps}; }
  GridStrain strain() const { return GridStrain(x, cells, 1.0 / cells); }
};

TEST(ContinuumLimiter, BoundsWarpWeftAndShearOfEveryTriangle) {
  for (const unsigned seed : {3u, 4u, 5u}) {
    Pulled net(seed);
    ASSERT_GT(net.strain().stretch, 0.3);
    ASSERT_GT(net.strain().shear, 0.2);
    net.method()->limit_ends(net.step(), net.x);
    EXPECT_LE(net.strain().stretch, kLimit + kTolerance);
    EXPECT_LE(net.strain().shear, kLimit * (1.0 + 0.5 * kLimit) + kTolerance);
  }
}

TEST(ContinuumLimiter, BringsOneComponentOfATriangleToItsLimit) {
  const std::vector<Spring> sides{{0, 1, 1.0, 1.0}, {0, 2, 1.0, 1.0}, {1, 2, std::sqrt(2.0), 1.0}};
  const std::vector<double> limits(3, kLimit), inv_mass{1.0, 0.5, 3.0};
  const Vectors rest{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  // Warp, weft, and shear to either side.
  const std::array<Mat3, 4> gradients{Vec3(1.3, 1.0, 1.0).asDiagonal().toDenseMatrix(),
                                      Vec3(0.9, 1.2, 1.0).asDiagonal().toDenseMatrix(),
                                      (Mat3() << 1, 0.15, 0, 0.15, 1, 0, 0, 0, 1).finished(),
                                      (Mat3() << 1, -0.3, 0, 0, 1, 0, 0, 0, 1).finished()};
  for (std::size_t g = 0; g < gradients.size(); ++g) {
    Vectors x = rest;
    for (Vec3& p : x) p = gradients[g] * p;
    continuum(sides, limits, 3)->limit_ends({rest, inv_mass, 0.01, 1e-10, 100}, x);
    const Vec3 warp = x[1] - x[0], weft = x[2] - x[0];
    const std::array<double, 4> at{warp.norm() - 1.0, weft.norm() - 1.0, 0.5 * warp.dot(weft),
                                   -0.5 * warp.dot(weft)};
    const double most = g < 2 ? kLimit : kLimit * (1.0 + 0.5 * kLimit);
    EXPECT_NEAR(at[g], most, g < 2 ? 1e-9 : 1e-3) << g;  // a gradient step of the shear overshoots
    for (int other = 0; other < 2; ++other) EXPECT_LE(at[other], kLimit + 1e-9) << g;
  }
}

TEST(ContinuumLimiter, SpringsOnTheBiasStretchUpToTwiceTheLimit) {
  // Warp and weft at their limits and shear at its own: no triangle is beyond a limit.
  Pulled net(1, 1.0, 0.0, 0.0);
  const double at = 1.0 + kLimit, sine = 2.0 * kLimit * (1.0 + 0.5 * kLimit) / (at * at);
  for (std::size_t i = 0; i < net.x.size(); ++i) {
    const Vec3& p = net.x_t0[i];
    net.x[i] = at * Vec3(p.x() + sine * p.y(), std::sqrt(1.0 - sine * sine) * p.y(), 0.0);
  }
  const Vectors before = net.x;
  const StrainReport report = net.method()->limit_ends(net.step(), net.x);
  EXPECT_EQ(net.x, before);
  EXPECT_NEAR(report.max_strain, std::sqrt(1.0 + 4.0 * kLimit + 2.0 * kLimit * kLimit) - 1.0,
              1e-12);
}

TEST(ContinuumLimiter, KeepsMomentumAndAngularMomentumOfEachSweep) {
  Pulled net(7);
  const auto momenta = [&] {
    Vec3 linear = Vec3::Zero(), turning = Vec3::Zero();
    const Pulled start(7);
    for (std::size_t i = 0; i < net.x.size(); ++i) {
      const Vec3 moved = net.cloth.mass[i] * (net.x[i] - start.x[i]);
      linear += moved;
      turning += start.x[i].cross(moved);
    }
    return std::pair(linear.norm(), turning.norm());
  };
  net.method()->limit_ends(net.step(), net.x);
  EXPECT_LT(momenta().first, 1e-14);
  // One component of one triangle has no moment; what follows starts from where it left.
  const std::vector<Spring> sides{{0, 1, 1.0, 1.0}, {0, 2, 1.0, 1.0}, {1, 2, std::sqrt(2.0), 1.0}};
  const std::vector<double> limits(3, kLimit), inv_mass{1.0, 0.5, 3.0};
  const Vectors before{{0.1, 0, 0}, {1.4, 0.2, 0.1}, {0.1, 0.9, -0.2}};
  Vectors x = before;
  continuum(sides, limits, 3)->limit_ends({before, inv_mass, 0.01, kTolerance, 1}, x);
  Vec3 linear = Vec3::Zero(), turning = Vec3::Zero();
  double most = 0.0;
  for (int i = 0; i < 3; ++i) {
    linear += (x[i] - before[i]) / inv_mass[i];
    turning += before[i].cross(x[i] - before[i]) / inv_mass[i];
    most = std::max(most, (x[i] - before[i]).norm());
  }
  ASSERT_GT(most, 0.05);
  EXPECT_LT(linear.norm(), 1e-15);
  EXPECT_LT(turning.norm(), 1e-15);
}

TEST(ContinuumLimiter, TurnsWithTheCloth) {
  const Eigen::AngleAxisd turn(1.1, Vec3(1, 2, -1).normalized());
  const Vec3 shift(3, -2, 5);
  Pulled net(9), turned(9);
  for (Vectors* x : {&turned.x, &turned.x_t0})
    for (Vec3& p : *x) p = turn * p + shift;
  net.method()->limit_ends(net.step(20), net.x);
  turned.method()->limit_ends(turned.step(20), turned.x);
  for (std::size_t i = 0; i < net.x.size(); ++i)
    EXPECT_LT((turn * net.x[i] + shift - turned.x[i]).norm(), 1e-12) << i;
}

TEST(ContinuumLimiter, OfATriangularMeshBoundsItsOwnTriangles) {
  const ClothMesh cloth = make_triangular({1.0, 1.0, 8, 9}, Material{});
  const std::vector<double> limits(cloth.springs.size(), kLimit);
  std::vector<double> inv_mass;
  for (const double m : cloth.mass) inv_mass.push_back(1.0 / m);
  Vectors x = random_vectors(cloth.mass.size(), 0.03, 5);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += cloth.surface.vertices[i];
  // No direction stretches by more than warp, weft and shear together.
  const double most = std::sqrt(1.0 + 4.0 * kLimit + 2.0 * kLimit * kLimit) - 1.0;
  const auto method = continuum(cloth.springs, limits, x.size());
  ASSERT_GT(method->limiter()->measure(x).max_strain, most + 0.05);
  const StrainReport report =
      method->limit_ends({cloth.surface.vertices, inv_mass, 0.01, kTolerance, 5000}, x);
  EXPECT_GT(report.sweeps, 0);
  EXPECT_LT(report.sweeps, 5000);
  EXPECT_LE(report.max_strain, most + 2.0 * kTolerance);
}

TEST(ContinuumLimiter, TakesWarpAndWeftFromTheRestShapeOfAMesh) {
  const ClothMesh cloth = make_triangular({1.0, 1.0, 8, 9}, Material{});
  const std::vector<double> limits(cloth.springs.size(), kLimit);
  std::vector<double> inv_mass;
  for (const double m : cloth.mass) inv_mass.push_back(1.0 / m);
  const LimitStep step{cloth.surface.vertices, inv_mass, 0.01, kTolerance, 5000};
  // Warp, weft and shear stay below their limits; the sides of the triangles do not.
  const Mat3 bias = 1.07 * (Mat3() << 1, 0.085, 0, 0.085, 1, 0, 0, 0, 1).finished();
  Vectors x = cloth.surface.vertices;
  for (Vec3& p : x) p = bias * p;
  const Vectors before = x;
  const auto method = continuum(cloth.springs, limits, x.size());
  EXPECT_GT(method->limit_ends(step, x).sweeps, 0) << "without directions a side is warp";
  x = before;
  method->set_directions(cloth.surface.triangles, cloth.surface);
  EXPECT_EQ(method->limit_ends(step, x).sweeps, 0);
  EXPECT_EQ(x, before);
  // Pulled along warp: weft keeps its length.
  for (std::size_t i = 0; i < x.size(); ++i) {
    x[i] = cloth.surface.vertices[i];
    x[i].x() *= 1.3;
  }
  method->limit_ends(step, x);
  for (const Triangle& t : cloth.surface.triangles) {
    Mat3 rest = Mat3::Identity(), end = Mat3::Identity();
    for (int k = 0; k < 2; ++k) {
      rest.col(k) = cloth.surface.vertices[t[k + 1]] - cloth.surface.vertices[t[0]];
      end.col(k) = x[t[k + 1]] - x[t[0]];
    }
    const Mat3 f = end * rest.inverse();
    EXPECT_LE(f.col(0).norm(), 1.0 + kLimit + kTolerance);
    EXPECT_NEAR(f.col(1).norm(), 1.0, 0.05);
  }
}

TEST(ContinuumLimiter, SpringsOverTwoCellsEncloseNoTriangle) {
  Material material;
  const ClothMesh net = make_spring_net(SpringNet::rectangular, {1.0, 1.0, 10, 10},
                                        {500.0, 500.0, 500.0, false}, material);
  Pulled plain(11);
  Vectors with = plain.x, without = plain.x;
  const std::vector<double> limits(net.springs.size(), kLimit);
  continuum(net.springs, limits, with.size())->limit_ends(plain.step(), with);
  plain.method()->limit_ends(plain.step(), without);
  // The triangles come in another order, but their limits are the same.
  EXPECT_LE(GridStrain(with, 10, 0.1).stretch, kLimit + kTolerance);
  for (std::size_t i = 0; i < with.size(); ++i) EXPECT_LT((with[i] - without[i]).norm(), 0.01) << i;
}

TEST(ContinuumLimiter, LengthensWarpAndWeftWithCompressionAlone) {
  Pulled net(13, 0.8, 0.0, 0.004);
  const Vectors before = net.x;
  ASSERT_LT(net.strain().shear, kLimit);
  net.method()->limit_ends(net.step(), net.x);
  EXPECT_EQ(net.x, before);
  continuum(net.cloth.springs, net.limits, net.x.size(), true)->limit_ends(net.step(), net.x);
  EXPECT_LE(net.strain().compression, kLimit + kTolerance);
}

}  // namespace
}  // namespace selvedge::continuum_limiter_test
