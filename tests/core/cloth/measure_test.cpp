// SPDX-License-Identifier: MIT
//
// Measures against shapes with closed forms.
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace selvedge::measure_test {
namespace {

constexpr double pi = std::numbers::pi;

TriangleMesh disc(double radius, int rings, int spokes) {
  return make_arc({radius, rings, spokes}, Material{}).surface;
}

/// Area of the regular polygon with this circumradius.
double polygon(double radius, int corners) {
  return 0.5 * corners * radius * radius * std::sin(2.0 * pi / corners);
}

TEST(Shadow, OfAFlatDiscGivesADrapeCoefficientOfOneHundred) {
  const TriangleMesh mesh = disc(0.15, 7, 64);
  const double area = projected_area(mesh.vertices, mesh.triangles);
  EXPECT_NEAR(area, polygon(0.15, 64), 1e-15);
  EXPECT_NEAR(drape_coefficient(area, surface_area(mesh.vertices, mesh.triangles), pi * 0.0081),
              100.0, 1e-9);
}

TEST(Shadow, OfAConeIsThatOfItsBaseAndTheCoefficientFollows) {
  TriangleMesh mesh = disc(0.15, 7, 64);
  const double tilt = pi / 6.0;
  for (Vec3& p : mesh.vertices) {
    const double r = p.head<2>().norm();
    p *= std::cos(tilt);
    p.z() = -r * std::sin(tilt);
  }
  const double area = projected_area(mesh.vertices, mesh.triangles);
  EXPECT_NEAR(area, 0.75 * polygon(0.15, 64), 1e-15);
  EXPECT_NEAR(surface_area(mesh.vertices, mesh.triangles), std::cos(tilt) * polygon(0.15, 64),
              1e-4);
  const double specimen = polygon(0.15, 64), support = 0.3 * specimen;
  EXPECT_NEAR(drape_coefficient(area, specimen, support), 100.0 * 0.45 / 0.7, 1e-9);
}

TEST(Shadow, CountsWhatOverlapsOnce) {
  // Two unit squares, the second moved by (0.3, 0.4), and a third below both.
  TriangleMesh mesh;
  for (const Vec3& at : {Vec3(0, 0, 0), Vec3(0.3, 0.4, 1), Vec3(0.1, 0.1, 2)}) {
    const auto first = static_cast<std::int32_t>(mesh.vertices.size());
    for (const Vec3& corner : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)})
      mesh.vertices.push_back(at + corner);
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 3, first + 2});  // faces down
  }
  const auto two = std::span(mesh.triangles).first(4);
  EXPECT_NEAR(projected_area(mesh.vertices, two), 2.0 - 0.7 * 0.6, 1e-14);
  // The third adds what sticks out of the union: two thin corners.
  EXPECT_NEAR(projected_area(mesh.vertices, mesh.triangles), 1.58 + 0.1 * 0.3 + 0.1 * 0.2, 1e-14);
}

TEST(Shadow, OfRandomTrianglesIsThatOfInclusionAndExclusion) {
  // Crossing triangles: the area of the union of two convex polygons by a fine sample.
  const std::vector<Vec3> x = {{0, 0, 0},     {1, 0.2, 0},   {0.3, 0.9, 0},
                               {0.1, 0.7, 1}, {0.9, 0.6, 1}, {0.4, -0.3, 1}};
  const std::vector<Triangle> t = {{0, 1, 2}, {3, 5, 4}};
  const auto inside = [&](double px, double py, const Triangle& tri) {
    const auto side = [&](int k) {
      const Vec3 a = x[tri[k]], b = x[tri[(k + 1) % 3]];
      return (b.x() - a.x()) * (py - a.y()) - (b.y() - a.y()) * (px - a.x());
    };
    const double s0 = side(0), s1 = side(1), s2 = side(2);
    return (s0 >= 0 && s1 >= 0 && s2 >= 0) || (s0 <= 0 && s1 <= 0 && s2 <= 0);
  };
  constexpr int n = 1000;
  int hits = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double px = (i + 0.5) / n, py = -0.5 + 1.5 * (j + 0.5) / n;
      hits += inside(px, py, t[0]) || inside(px, py, t[1]) ? 1 : 0;
    }
  EXPECT_NEAR(projected_area(x, t), 1.5 * hits / (double(n) * n), 2e-3);
}

TEST(Shadow, TurnsWithTheCloth) {
  TriangleMesh mesh = disc(0.15, 12, 48);
  for (Vec3& p : mesh.vertices) {  // a wavy, overhanging drape
    const double r = p.head<2>().norm(), angle = std::atan2(p.y(), p.x());
    const double out = 0.09 + (0.03 + 0.02 * std::cos(5 * angle)) * std::sin(30 * (r - 0.09));
    if (r > 0.09) p = Vec3(out * std::cos(angle), out * std::sin(angle), 0.09 - r);
  }
  const double area = projected_area(mesh.vertices, mesh.triangles);
  const Eigen::AngleAxisd turn(0.7321, Vec3::UnitZ());
  for (Vec3& p : mesh.vertices) p = turn * p + Vec3(3.0, -2.0, 1.0);
  EXPECT_NEAR(projected_area(mesh.vertices, mesh.triangles) / area, 1.0, 1e-9);
  EXPECT_LT(area, pi * 0.14 * 0.14);
  EXPECT_GT(area, pi * 0.09 * 0.09);
}

TEST(DrapeCoefficient, RefusesASpecimenSmallerThanItsSupport) {
  EXPECT_THROW(drape_coefficient(0.1, 0.02, 0.03), std::invalid_argument);
  EXPECT_THROW(drape_coefficient(0.1, 0.2, -1.0), std::invalid_argument);
}

TEST(StripElastica, HasTheTableOfDrapeCoefficients) {
  // PHYSICS: bending length in mm, percent.
  const double table[][2] = {{6, 3.5},   {8, 5.5},   {10, 8.0},  {12, 11.0}, {15, 16.8}, {18, 24.6},
                             {20, 30.9}, {25, 49.3}, {30, 67.5}, {40, 89.7}, {60, 98.9}};
  for (const auto& [c, percent] : table)
    EXPECT_NEAR(strip_drape_coefficient(1e-3 * c), percent, 0.06) << c << " mm";
}

TEST(Rim, OfAnNFoldCosineHasNFoldsAndItsAmplitude) {
  for (const int folds : {2, 3, 5, 8}) {
    TriangleMesh mesh = disc(0.15, 3, 360);
    for (Vec3& p : mesh.vertices) {
      const double angle = std::atan2(p.y(), p.x());
      p *= 1.0 + 0.1 * std::cos(folds * angle);
    }
    const RimProfile rim = rim_profile(mesh.vertices, mesh.triangles, {Vec3::Zero(), 720});
    EXPECT_EQ(rim.folds, folds);
    EXPECT_EQ(rim.maxima, folds);
    EXPECT_NEAR(rim.amplitude[0], 0.15, 1e-5);
    EXPECT_NEAR(rim.amplitude[folds], 0.015, 5e-5);  // chords of 1 degree
    EXPECT_LT(rim.amplitude[folds + 1], 5e-5);
  }
}

TEST(Rim, OfADiscIsRoundAndOfABallThereIsNone) {
  TriangleMesh mesh = disc(0.15, 3, 720);
  const RimProfile rim = rim_profile(mesh.vertices, mesh.triangles, {Vec3::Zero(), 720});
  EXPECT_EQ(rim.folds, 0);
  EXPECT_EQ(rim.maxima, 0);
  EXPECT_THROW(rim_profile(mesh.vertices, mesh.triangles, {Vec3(1, 0, 0), 720}),
               std::invalid_argument);
  mesh.triangles = {{0, 1, 2}, {0, 2, 1}};
  EXPECT_THROW(rim_profile(mesh.vertices, mesh.triangles, {}), std::invalid_argument);
}

TEST(Strain, OfAnAffineMapIsItsPrincipalStretches) {
  const TriangleMesh rest = disc(0.2, 4, 12);
  std::vector<Vec3> x;
  const Eigen::AngleAxisd turn(0.9, Vec3(1, 2, 3).normalized());
  const double c = std::cos(0.4), s = std::sin(0.4);
  for (const Vec3& p : rest.vertices) {  // 7 % along a direction at 0.4 rad, -3 % across
    const double u = 1.07 * (c * p.x() + s * p.y()), v = 0.97 * (c * p.y() - s * p.x());
    x.push_back(turn * Vec3(u, v, 0.0));
  }
  for (const TriangleStrain& t : triangle_strains(x, rest.triangles, rest)) {
    EXPECT_NEAR(t.larger, 0.07, 1e-12);
    EXPECT_NEAR(t.smaller, -0.03, 1e-12);
  }
  const StrainSummary sum = summary_of(triangle_strains(x, rest.triangles, rest));
  EXPECT_NEAR(sum.max, 0.07, 1e-12);
  EXPECT_NEAR(sum.min, -0.03, 1e-12);
  EXPECT_NEAR(sum.mean, 0.02, 1e-12);
  EXPECT_NEAR(sum.rms, std::sqrt(0.5 * (0.0049 + 0.0009)), 1e-12);
}

TEST(Strain, OfSpringsIsTheirStretch) {
  const std::vector<Vec3> x = {{0, 0, 0}, {1.1, 0, 0}, {1.1, 0.9, 0}};
  const std::vector<Spring> springs = {{0, 1, 1.0, 1.0}, {1, 2, 1.0, 1.0}};
  const StrainSummary sum = spring_strains(springs, x);
  EXPECT_NEAR(sum.max, 0.1, 1e-12);
  EXPECT_NEAR(sum.min, -0.1, 1e-12);
  EXPECT_NEAR(sum.rms, 0.1, 1e-12);
  EXPECT_NEAR(sum.mean, 0.0, 1e-12);
}

}  // namespace
}  // namespace selvedge::measure_test
