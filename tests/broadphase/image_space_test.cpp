// SPDX-License-Identifier: MIT
// Image space against closed forms (maps) and against brute force (pairs), each with the error that
// its header states.
#include <gtest/gtest.h>
#include <selvedge/broadphase/image_space/image_space.h>
#include <selvedge/compare/detectors/conformance.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/base/types.h>
#include <selvedge/data/makers/mannequin.h>
#include <selvedge/scene/methods.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/step_report.h>

#include <Eigen/Geometry>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "owned_surface.h"

namespace selvedge::image_space_test {
namespace {

constexpr double kPi = std::numbers::pi;
using Surface = OwnedSurface;

Surface surface_of(TriangleMesh mesh) {
  Surface s{mesh.vertices, mesh.vertices, unique_edges(mesh.triangles), mesh.triangles};
  return s;
}

/// A closed surface of two angles, `n` by `m` cells; `at(u, v)` with u and v of period 1.
template <class At>
Surface closed_in_both(int n, int m, At at) {
  TriangleMesh mesh;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) mesh.vertices.push_back(at(double(i) / n, double(j) / m));
  const auto index = [&](int i, int j) { return (i % n) * m + j % m; };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      mesh.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      mesh.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
  return surface_of(std::move(mesh));
}

constexpr double kRing = 0.5, kTube = 0.2;

/// About the z axis.
Surface torus(int n, int m) {
  return closed_in_both(n, m, [](double u, double v) {
    const double a = 2 * kPi * u, b = 2 * kPi * v, r = kRing + kTube * std::cos(b);
    return Vec3(r * std::cos(a), r * std::sin(a), kTube * std::sin(b));
  });
}

/// Radius 1 about `center`, vertices on the sphere; poles on the x axis so that no view is special.
constexpr int kRings = 120, kSectors = 240;
Surface sphere(const Vec3& center, int rings = kRings, int sectors = kSectors) {
  TriangleMesh mesh;
  const auto point = [&](double polar, double around) {
    return Vec3(center + Vec3(std::cos(polar), std::sin(polar) * std::cos(around),
                              std::sin(polar) * std::sin(around)));
  };
  mesh.vertices.push_back(point(0, 0));
  for (int i = 1; i < rings; ++i)
    for (int j = 0; j < sectors; ++j)
      mesh.vertices.push_back(point(kPi * i / rings, 2 * kPi * j / sectors));
  mesh.vertices.push_back(point(kPi, 0));
  const auto index = [&](int i, int j) { return 1 + (i - 1) * sectors + j % sectors; };
  const auto last = static_cast<std::int32_t>(mesh.vertices.size()) - 1;
  for (int j = 0; j < sectors; ++j) {
    mesh.triangles.push_back({0, index(1, j), index(1, j + 1)});
    for (int i = 1; i + 1 < rings; ++i) {
      mesh.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      mesh.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
    mesh.triangles.push_back({index(rings - 1, j), last, index(rings - 1, j + 1)});
  }
  return surface_of(std::move(mesh));
}

/// Farthest that the facets of the unit sphere lie beneath it: a facet fits into a cap whose chord
/// is the diagonal of a cell.
double facet_sag(int rings = kRings, int sectors = kSectors) {
  const double half_diagonal = 0.5 * std::hypot(kPi / rings, 2 * kPi / sectors);
  return 1.0 - std::cos(half_diagonal);
}

Surface sheet(int n, double size, const Vec3& corner) {
  TriangleMesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      mesh.vertices.push_back(corner + Vec3(size * i / n, size * j / n, 0.0));
  const auto at = [n](int i, int j) { return j * (n + 1) + i; };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return surface_of(std::move(mesh));
}

/// A cloth that lies around `body`: each vertex of a tube of n by n cells is drawn to the body's
/// surface along the horizontal, by the nearest vertex, and moves a little.
Surface wrapped_on(const Surface& body, int n, double step) {
  Vec3 lo = body.x_t0[0], hi = lo;
  for (const Vec3& x : body.x_t0) {
    lo = lo.cwiseMin(x);
    hi = hi.cwiseMax(x);
  }
  const Vec3 middle = 0.5 * (lo + hi);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> jiggle(-step, step);
  Surface s = closed_in_both(n, n, [&](double u, double v) {
    const double a = 2 * kPi * u;
    const double up = 0.5 - 0.5 * std::cos(2 * kPi * v);  // there and back
    return Vec3(middle[0] + 0.5 * (hi[0] - lo[0]) * std::cos(a),
                middle[1] + 0.5 * (hi[1] - lo[1]) * std::sin(a), lo[2] + up * (hi[2] - lo[2]));
  });
  for (std::size_t i = 0; i < s.x_t0.size(); ++i) {
    const Vec3* nearest = &body.x_t0[0];
    for (const Vec3& x : body.x_t0)
      if ((x - s.x_t0[i]).squaredNorm() < (*nearest - s.x_t0[i]).squaredNorm()) nearest = &x;
    s.x_t0[i] = *nearest + 0.01 * (s.x_t0[i] - *nearest);
    s.x_t1[i] = s.x_t0[i] + Vec3(jiggle(random), jiggle(random), jiggle(random));
  }
  s.thickness = 0.001;
  return s;
}

CandidatePairs pairs_of(BroadPhase& detector, const Surface& a, const Surface& b) {
  CandidatePairs out;
  detector.find_pairs(a.view(), b.view(), out);
  return out;
}

template <class Pair>
std::size_t common(const std::vector<Pair>& a, const std::vector<Pair>& b) {
  std::vector<Pair> both;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  return both.size();
}

/// Part of `all` that is in `found`. Every list of `found` must be a part of that of `all`.
double recall(const CandidatePairs& found, const CandidatePairs& all) {
  const std::size_t both = common(found.point_triangle, all.point_triangle) +
                           common(found.triangle_point, all.triangle_point) +
                           common(found.edge_edge, all.edge_edge);
  EXPECT_EQ(both, found.size()) << "a pair that brute force does not report";
  return all.size() == 0 ? 1.0 : static_cast<double>(both) / static_cast<double>(all.size());
}

bool same(const CandidatePairs& a, const CandidatePairs& b) {
  return a.point_triangle == b.point_triangle && a.triangle_point == b.triangle_point &&
         a.edge_edge == b.edge_edge;
}

std::vector<ParticleAnswer> answers(const DepthNormalMaps& maps, const std::vector<Vec3>& points) {
  std::vector<ParticleAnswer> out(points.size());
  maps.answer(points, out);
  return out;
}

template <class F>
std::string refusal(F f) {
  try {
    f();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "not refused";
}

// ---- depth and normal maps -----------------------------------------------------------------

/// Places within 60 degrees of the axis, where the sphere's slope is at most tan 60°.
constexpr double kWidest = 60.0 * kPi / 180.0;

TEST(DepthNormalMaps, DepthAndNormalOfASphereLieWithinTheStatedError) {
  const Vec3 center(3.0, -2.0, 100.0), axis = Vec3(1.0, 2.0, -0.5).normalized();
  const Surface body = sphere(center);
  for (const int resolution : {64, 256, 1024}) {
    DepthNormalMaps maps({.resolution = resolution, .axis = axis});
    maps.update(body.view());
    EXPECT_LT((maps.center() - center).norm(), 2e-3);
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    std::vector<Vec3> directions, points;
    while (points.size() < 4000) {
      const Vec3 d = Vec3(normal(random), normal(random), normal(random)).normalized();
      if (std::abs(d.dot(axis)) < std::cos(kWidest)) continue;
      directions.push_back(d);
      points.push_back(center + d);
    }
    const auto seen = answers(maps, points);
    // A point and the texels about it lie on chords of the sphere, whose slope is nowhere more than
    // at the outer end of a cell: the sine grows by a diagonal.
    double worst_depth = 0.0, worst_angle = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_TRUE(seen[i].covered);
      EXPECT_EQ(seen[i].front, directions[i].dot(axis) > 0.0);
      const double sine = directions[i].cross(axis).norm() + 2.0 * maps.sideways_error();
      const double slope = std::tan(std::asin(std::min(sine, 0.999)));
      const double facets = 2.0 * facet_sag() + 0x1p-21;
      EXPECT_LE(std::abs(seen[i].depth), slope * maps.sideways_error() + facets);
      // z = √(1 - x² - y²): the two second derivatives sum to 1/cos³ + 1/cos.
      const double cosine = std::sqrt(1.0 - sine * sine);
      const double bend = 1.0 / (cosine * cosine * cosine) + 1.0 / cosine;
      EXPECT_LE(std::abs(seen[i].depth), maps.texel() * maps.texel() / 8.0 * bend + facets);
      worst_depth = std::max(worst_depth, std::abs(seen[i].depth));
      worst_angle =
          std::max(worst_angle, std::acos(std::min(1.0, seen[i].normal.dot(directions[i]))));
    }
    // The normal is that of a place at most a cell's diagonal, seen on the sphere, away.
    EXPECT_LE(worst_angle, 2.0 * maps.sideways_error() / std::cos(kWidest) + 0.5 * kPi / kRings);
    std::printf("resolution %4d: texel %.2e, depth off by %.2e, normal by %.3f degrees\n",
                resolution, maps.texel(), worst_depth, worst_angle * 180.0 / kPi);
  }
}

TEST(DepthNormalMaps, ParticlesAreInsideOrNotOutsideABandOfTheStatedError) {
  const Surface body = sphere(Vec3::Zero());
  DepthNormalMaps maps({.resolution = 256, .axis = Vec3::UnitZ()});
  maps.update(body.view());
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-1.3, 1.3);
  std::vector<Vec3> points(20000);
  for (Vec3& p : points) p = Vec3(place(random), place(random), place(random));
  const auto seen = answers(maps, points);
  std::size_t inside = 0, judged = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double across = points[i].head<2>().norm();
    if (across > 1.0 + 2.0 * maps.sideways_error()) {
      EXPECT_FALSE(seen[i].covered);
    }
    if (across + 2.0 * maps.sideways_error() > std::sin(kWidest)) continue;
    const double half = std::sqrt(1.0 - across * across);
    const double true_depth = half - std::abs(points[i][2]);
    const double bound = std::tan(kWidest) * maps.sideways_error() + 2.0 * facet_sag() + 0x1p-21;
    ASSERT_TRUE(seen[i].covered);
    EXPECT_NEAR(seen[i].depth, true_depth, bound);
    if (std::abs(true_depth) <= bound) continue;
    EXPECT_EQ(seen[i].inside, true_depth > 0.0);
    inside += seen[i].inside;
    ++judged;
  }
  EXPECT_GT(inside, 1000u);
  EXPECT_GT(judged - inside, 1000u);
}

TEST(DepthNormalMaps, TheHoleOfATorusIsSeenAlongItsAxisOnly) {
  const Surface body = torus(120, 60);
  const std::vector<Vec3> points = {Vec3::Zero(), Vec3(kRing, 0, 0), Vec3(0, kRing, 0.1)};
  DepthNormalMaps along;  // the shortest side of its box is its axis
  along.update(body.view());
  EXPECT_TRUE(along.axis().isApprox(Vec3::UnitZ()));
  const auto right = answers(along, points);
  EXPECT_FALSE(right[0].covered);
  EXPECT_TRUE(right[1].inside);
  EXPECT_TRUE(right[2].inside);

  DepthNormalMaps across({.axis = Vec3::UnitX()});
  across.update(body.view());
  const auto wrong = answers(across, points);
  EXPECT_TRUE(wrong[0].inside) << "the documented miss: only the outermost sides are known";
  EXPECT_NEAR(wrong[0].depth, kRing + kTube, 0.01);
  EXPECT_TRUE(wrong[1].inside);
}

TEST(DepthNormalMaps, TheDisplacementOfTheBodyIsThatOfItsVertices) {
  Surface body = sphere(Vec3::Zero(), 40, 80);
  const Mat3 spin = (Mat3() << 0, -0.1, 0, 0.1, 0, 0, 0, 0, 0).finished();
  for (std::size_t i = 0; i < body.x_t0.size(); ++i) {
    body.x_t1[i] = body.x_t0[i];
    body.x_t0[i] -= spin * body.x_t1[i] + Vec3(0, 0, 0.2);
  }
  DepthNormalMaps maps({.resolution = 512, .axis = Vec3::UnitZ()});
  maps.update(body.view());
  const Vec3 point(0.3, 0.4, 2.0);
  const ParticleAnswer seen = answers(maps, {point})[0];
  ASSERT_TRUE(seen.covered);
  EXPECT_NEAR(seen.displacement[2], 0.2, 1e-6);
  EXPECT_NEAR(seen.displacement[0], -0.1 * point[1], 1e-5);  // linear on each triangle: exact
  EXPECT_NEAR(seen.displacement[1], 0.1 * point[0], 1e-5);
}

TEST(DepthNormalMaps, ABodyIsDrawnOnceAndAgainOnlyAfterItMoved) {
  Surface body = sphere(Vec3::Zero(), 20, 40);
  body.static_id = 9;
  DepthNormalMaps maps({.resolution = 64});
  EXPECT_TRUE(maps.update(body.view()));
  EXPECT_FALSE(maps.update(body.view()));
  body.static_id = 0;
  EXPECT_FALSE(maps.update(body.view()));
  body.x_t1[17] *= 1.01;
  EXPECT_TRUE(maps.update(body.view()));
  EXPECT_EQ(maps.renders(), 2u);
}

TEST(DepthNormalMaps, TheSameBodyGivesTheSameBytesForAnyNumberOfThreads) {
  const Surface body = torus(80, 40);
  std::vector<Vec3> points;
  for (int i = 0; i < 5000; ++i)
    points.push_back(Vec3(0.7 * std::sin(i), 0.7 * std::sin(2.3 * i), 0.2 * std::sin(3.1 * i)));
  std::vector<std::vector<float>> depths;
  std::vector<std::vector<double>> reported;
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    DepthNormalMaps maps({.resolution = 300, .axis = Vec3(1, 1, 1)});
    maps.update(body.view());
    depths.push_back(maps.front().depth);
    std::vector<double>& mine = reported.emplace_back();
    for (const ParticleAnswer& a : answers(maps, points)) mine.push_back(a.depth);
  }
  EXPECT_EQ(depths[0], depths[1]);
  EXPECT_EQ(depths[0], depths[2]);
  EXPECT_EQ(reported[0], reported[1]);
  EXPECT_EQ(reported[0], reported[2]);
}

TEST(DepthNormalMaps, BadInputIsRefusedInOneSentence) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal([] { DepthNormalMaps({.resolution = 15}); }).find("15 texels"),
            std::string::npos);
  EXPECT_NE(refusal([] { DepthNormalMaps({.resolution = 4097}); }).find("4097 texels"),
            std::string::npos);
  EXPECT_NE(refusal([&] { DepthNormalMaps({.axis = Vec3(nan, 0, 0)}); }).find("axis"),
            std::string::npos);
  DepthNormalMaps maps({.resolution = 64});
  std::vector<ParticleAnswer> room(1);
  const std::vector<Vec3> point = {Vec3::Zero()}, bad_point = {Vec3(0, nan, 0)};
  EXPECT_NE(refusal([&] { maps.answer(point, room); }).find("no body"), std::string::npos);
  EXPECT_NE(refusal([&] { maps.update({}); }).find("no triangles"), std::string::npos);
  Surface body = sphere(Vec3::Zero(), 8, 16);
  body.x_t1[5][1] = nan;
  EXPECT_NE(refusal([&] { maps.update(body.view()); }).find("vertex 5"), std::string::npos);
  body.x_t1[5] = Vec3(0, 0, 1e200);
  EXPECT_NE(refusal([&] { maps.update(body.view()); }).find("vertex 5"), std::string::npos);
  const Surface open = sheet(3, 1.0, Vec3::Zero());
  EXPECT_NE(refusal([&] { maps.update(open.view()); }).find("close it"), std::string::npos);
  body.x_t1 = body.x_t0;
  maps.update(body.view());
  EXPECT_NE(refusal([&] { maps.answer(bad_point, room); }).find("point 0"), std::string::npos);
  EXPECT_NE(refusal([&] { maps.answer(point, {}); }).find("room for 0"), std::string::npos);

  DepthNormalMaps lenient({.resolution = 64, .allow_open = true});
  EXPECT_TRUE(lenient.update(open.view()));
}

TEST(DepthNormalMaps, WithoutTheRightDriverItSaysWhichOneIsNeeded) {
  ASSERT_EQ(setenv("GALLIUM_DRIVER", "softpipe", 1), 0);
  DepthNormalMaps maps({.resolution = 64});
  const Surface body = sphere(Vec3::Zero(), 8, 16);
  try {
    maps.update(body.view());
    ADD_FAILURE() << "drawn by softpipe";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("llvmpipe"), std::string::npos);
  }
  ASSERT_EQ(unsetenv("GALLIUM_DRIVER"), 0);
  EXPECT_TRUE(maps.update(body.view())) << "and can be used once it is there";
}

/// Of a closed body whose every triangle is seen from somewhere. What is still lost are pairs of
/// boxes whose corners overlap where no part of the triangle is to be seen.
constexpr double kBestRecall = 0.999;
/// A window is read by whole tiles, which shrink as the resolution grows: once all triangles are
/// seen, recall may fall by as much as the tiles gave beyond the windows.
constexpr double kTileNoise = 1e-4;

// ---- particles -----------------------------------------------------------------------------

Surface particles(std::vector<Vec3> x) {
  Surface s;
  s.x_t0 = s.x_t1 = std::move(x);
  return s;
}

std::vector<ParticleContact> contacts_of(BroadPhase& detector, const Surface& a, const Surface& b,
                                         double reach) {
  std::vector<ParticleContact> out;
  detector.find_particle_contacts(a.view(), b.view(), reach, out);
  return out;
}

/// Points at the given distances from the unit sphere about `center`, in all directions but those
/// for which `skip` is true.
template <class Skip>
Surface points_about_sphere(const Vec3& center, double least, double most, Skip skip) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> distance(least, most);
  std::vector<Vec3> x;
  while (x.size() < 3000) {
    const Vec3 d = Vec3(normal(random), normal(random), normal(random)).normalized();
    if (!skip(d)) x.push_back(center + (1.0 + distance(random)) * d);
  }
  return particles(std::move(x));
}

// The sphere's closed form: distance |p - c| - 1, normal (p - c)/|p - c|. Six pictures show every
// place of it under less than 54.8 degrees.
TEST(ParticleMaps, DistanceAndNormalOfASphereLieWithinTheStatedError) {
  const Vec3 center(-1.0, 0.5, 2.0);
  const Surface body = sphere(center);
  constexpr double kDeep = 0.02, kReach = 0.02;
  const Surface near =
      points_about_sphere(center, -kDeep, 0.75 * kReach, [](const Vec3&) { return false; });
  for (const int resolution : {128, 512}) {
    ParticleMaps detector({.resolution = resolution, .views = 3});
    const auto found = contacts_of(detector, near, body, kReach);
    ASSERT_EQ(found.size(), near.x_t1.size()) << "a particle was missed";
    // The depth along the axis, taken as distance by the cosine of the normal below, is off by
    // δ² tan²/2 for a sphere of radius 1, where the tangent is at most √2.
    const double error = detector.sideways_error();
    const double bound = error + kDeep * kDeep + 2.0 * kDeep * error + 2.0 * facet_sag();
    double worst = 0.0;
    for (const ParticleContact& c : found) {
      const Vec3 from_center = near.x_t1[c.pair.point] - center;
      EXPECT_NEAR(c.distance, from_center.norm() - 1.0, bound);
      worst = std::max(worst, std::abs(c.distance - (from_center.norm() - 1.0)));
      EXPECT_GT(c.normal.dot(from_center.normalized()),
                std::cos(4.0 * (error + kDeep) + 0.5 * kPi / kRings));
      const Triangle& t = body.triangles[c.pair.triangle];
      const Vec3 foot = c.weight[0] * body.x_t1[t[0]] + c.weight[1] * body.x_t1[t[1]] +
                        c.weight[2] * body.x_t1[t[2]];
      EXPECT_NEAR(c.weight.sum(), 1.0, 1e-12);
      EXPECT_NEAR(c.normal.dot(near.x_t1[c.pair.point] - foot), c.distance, bound + 2.0 * error)
          << "the contact's point lies on the body below the particle";
    }
    std::printf("resolution %4d: distance off by %.2e m, bound %.2e m\n", resolution, worst, bound);
  }
}

TEST(ParticleMaps, SideViewsAnswerParticlesBesideTheOutlineOfTheFront) {
  const Surface body = sphere(Vec3::Zero());
  // Beside the equator, outside the outline along z; the box of a sphere is a cube, so the first
  // view is along x and the second along y.
  const Surface beside = particles({Vec3(0.0, 1.01, 0.0), Vec3(0.0, 0.0, 1.01), Vec3(1.01, 0, 0)});
  for (const auto& [views, expected] :
       {std::pair{1, std::vector{2}}, {2, std::vector{0, 2}}, {3, std::vector{0, 1, 2}}}) {
    ParticleMaps detector({.resolution = 256, .views = views});
    std::vector<int> found;
    for (const ParticleContact& c : contacts_of(detector, beside, body, 0.02))
      found.push_back(c.pair.point);
    EXPECT_EQ(found, expected) << views << " views";
  }
}

TEST(ParticleMaps, AParticleFarInFrontOfASteepPlaceHasNoContact) {
  const Surface body = sphere(Vec3::Zero());
  // Seen along x, near the outline: the depth of 1.5 times the cosine is below the reach.
  const Surface far = particles({Vec3(1.5, 0.999, 0.0), Vec3(-1.5, 0.0, 0.999)});
  ParticleMaps detector({.resolution = 256, .views = 1});
  EXPECT_EQ(contacts_of(detector, far, body, 0.1).size(), 0u);
}

TEST(ParticleMaps, FrontAndBackHaveNormalsOutOfTheBody) {
  Surface body = sphere(Vec3::Zero());
  for (auto* xs : {&body.x_t0, &body.x_t1})
    for (Vec3& x : *xs) x[2] *= 0.5;  // now front and back are along z
  const Surface poles = particles({Vec3(0, 0, 0.45), Vec3(0, 0, -0.45), Vec3(0, 0, 0.52)});
  ParticleMaps detector({.resolution = 256, .views = 1});
  const auto found = contacts_of(detector, poles, body, 0.05);
  ASSERT_EQ(found.size(), 3u);
  for (const auto& [k, side, distance] :
       {std::tuple{0, 1.0, -0.05}, {1, -1.0, -0.05}, {2, 1.0, 0.02}}) {
    EXPECT_NEAR(found[k].normal[2], side, 1e-3);
    EXPECT_NEAR(found[k].distance, distance, 1e-3);
  }
}

TEST(ParticleMaps, AHoleIsABodyInOneViewAndFreeInAnother) {
  Surface ring = torus(120, 60);
  const auto stretch = [&](double z) {
    for (auto* xs : {&ring.x_t0, &ring.x_t1})
      for (Vec3& x : *xs) x[2] *= z;
  };
  const Surface middle = particles({Vec3::Zero()});
  stretch(5.0);  // longer along its axis than across it, so the first view is across
  ParticleMaps across({.resolution = 256, .views = 1}), all({.resolution = 256, .views = 3});
  EXPECT_EQ(contacts_of(across, middle, ring, 0.01).size(), 1u) << "the documented false contact";
  EXPECT_EQ(contacts_of(all, middle, ring, 0.01).size(), 0u);
}

TEST(ParticleMaps, ABodyAtRestIsDrawnOnce) {
  Surface body = sphere(Vec3::Zero(), 20, 40);
  body.static_id = 5;
  const Surface point = particles({Vec3(0.0, 0.0, 0.99)});
  ParticleMaps detector({.resolution = 64, .views = 2});
  CandidatePairs pairs;
  for (int step = 0; step < 4; ++step) {
    detector.find_pairs(point.view(), body.view(), pairs);
    contacts_of(detector, point, body, 0.1);
  }
  EXPECT_EQ(detector.renders(), 2u) << "one drawing for each view";
  body.static_id = 0;
  for (int step = 1; step <= 3; ++step) {
    for (Vec3& x : body.x_t1) x += Vec3(0.0, 0.01, 0.0);
    detector.find_pairs(point.view(), body.view(), pairs);
    contacts_of(detector, point, body, 0.1);
    EXPECT_EQ(detector.renders(), 2u + 2u * static_cast<unsigned>(step));
    body.x_t0 = body.x_t1;
  }
}

TEST(ParticleMaps, PassesTheConformanceKitAsAnApproximateDetector) {
  ConformanceConfig config;
  config.scenes = 200;
  const auto report = check_conformance(
      [] {
        return std::make_unique<ParticleMaps>(ParticleMapsConfig{128, 2});
      },
      config);
  EXPECT_TRUE(report.passed()) << report.summary();
  EXPECT_GT(report.calls, 20u);
  EXPECT_EQ(report.beyond, 0u);
  std::printf("%s\n", report.summary().c_str());
}

TEST(ParticleMaps, BadInputIsRefusedInOneSentence) {
  EXPECT_NE(refusal([] { ParticleMaps({.resolution = 8}); }).find("8 texels"), std::string::npos);
  EXPECT_NE(refusal([] { ParticleMaps({.views = 4}); }).find("4 views"), std::string::npos);
  ParticleMaps detector({.resolution = 64});
  CandidatePairs out;
  const Surface open = sheet(4, 1.0, Vec3::Zero());
  EXPECT_NE(refusal([&] { detector.find_self_pairs(open.view(), out); }).find("with itself"),
            std::string::npos);
  EXPECT_NE(refusal([&] { detector.find_pairs(open.view(), open.view(), out); }).find("close it"),
            std::string::npos);
}

/// A sheet that falls on a rough ball, answered by reflections (survey eq. 49).
Scene sheet_on_ball(const std::string& broad_phase) {
  Scene scene;
  scene.name = "test";
  scene.materials["default"] = Material{};
  ClothSpec cloth;
  cloth.name = "cloth";
  cloth.shape = ClothGrid{"rectangular", {0.3, 0.3, 24, 24}, {}};
  cloth.placement.translation = Vec3(0.011, 0.007, 0.104);
  scene.cloths.push_back(cloth);
  BodySpec body;
  body.name = "ball";
  body.shape = BodyShape{Sphere{0.1}, 16};
  scene.bodies.push_back(body);
  scene.contact.broad_phase = broad_phase;
  scene.contact.response = "reflection";
  scene.contact.rest_gap = 0.002;  // more than the ball rises above a cell of the cloth
  return scene;
}

/// Mean angle, in degrees, between the normals of the contacts of particles with the ball and the
/// directions from its middle; and the result.
std::pair<double, RunResult> run_on_ball(const Scene& scene) {
  Simulation simulation(scene, methods_of_this_build());
  double sum = 0.0;
  std::size_t count = 0;
  for (int frame = 1; frame <= 10; ++frame) {
    simulation.advance_to_frame(frame, {});
    const std::span<const Vec3> x = simulation.positions();
    for (const StepContact& c : simulation.contacts()) {
      const bool with_ball = static_cast<std::size_t>(c.point.vertex[3]) >= x.size();
      if (!with_ball || c.point.kind != ContactKind::point_triangle) continue;
      const Vec3 out = x[c.point.vertex[0]].normalized();
      sum += std::acos(std::min(1.0, out.dot(c.point.normal))) * 180.0 / kPi;
      ++count;
    }
  }
  EXPECT_GT(count, 20u) << scene.contact.broad_phase;
  return {sum / static_cast<double>(count), simulation.result()};
}

// The map interpolates normals; a triangle of the ball has one. So the normals tell which of them
// answered.
TEST(ParticleMapsScene, ASceneRunsWithContactsWhoseNormalsAreThoseOfTheMap) {
  Scene by_maps = sheet_on_ball("depth_normal_maps");
  by_maps.contact.broad_phase_options = {{"views", 3.0}};
  const auto [map_angle, result] = run_on_ball(by_maps);
  const auto [facet_angle, other] = run_on_ball(sheet_on_ball("bvh_aabb"));
  std::printf("normals off by %.2f degrees with maps, %.2f with triangles\n", map_angle,
              facet_angle);
  EXPECT_LT(map_angle, 0.6 * facet_angle);
  EXPECT_TRUE(result.clean) << "by the search of every frame, which the detector has no part in";
  EXPECT_GT(result.ledger.at("response").at("to_particles_z"), 0.0);
  EXPECT_GT(result.counters.at("substituted_depth_normal_maps_by_bvh_aabb"), 0.0);
  EXPECT_EQ(other.counters.count("substituted_bvh_aabb_by_bvh_aabb"), 0u);
}

TEST(ParticleMapsScene, AnOpenBodyIsRefused) {
  Scene scene = sheet_on_ball("depth_normal_maps");
  scene.bodies[0].shape = BodyShape{Plane{}, 4};
  scene.bodies[0].placement.translation = Vec3(0.0, 0.0, 0.1);
  EXPECT_NE(refusal([&] {
              Simulation simulation(scene, methods_of_this_build());
              simulation.advance_to_frame(1, {});
            }).find("close it"),
            std::string::npos);
}

TEST(ImageSpaceNames, TheFormerNameIsRefusedWithTheNearestOne) {
  BroadPhaseRegistry registry = broad_phases();
  register_image_space(registry);
  EXPECT_TRUE(registry.contains("depth_normal_maps"));
  EXPECT_NE(registry.fault("image_space").find("\"image_space_pairs\""), std::string::npos)
      << registry.fault("image_space");
}

// ---- pairs ---------------------------------------------------------------------------------

TEST(ImageSpacePairs, RecallGrowsWithTheResolutionToAlmostAllPairs) {
  const Surface body = surface_of(make_mannequin());
  const Surface cloth = wrapped_on(body, 40, 0.004);
  const CandidatePairs all = pairs_of(*make_brute_force(), cloth, body);
  ASSERT_GT(all.size(), 10000u);
  double last = 0.0;
  for (const int resolution : {64, 128, 256, 512, 1024}) {
    ImageSpacePairs detector({.resolution = resolution});
    const double part = recall(pairs_of(detector, cloth, body), all);
    std::printf("resolution %4d: recall %.5f of %zu pairs, %zu of %zu triangles unseen\n",
                resolution, part, all.size(), detector.unseen(), body.triangles.size());
    EXPECT_GE(part, last - kTileNoise);
    last = part;
  }
  EXPECT_GE(last, kBestRecall);
}

TEST(ImageSpacePairs, ATorusHidesNoTriangleFromItsSixSides) {
  const Surface body = torus(60, 30);
  const Surface cloth = wrapped_on(body, 30, 0.01);
  const CandidatePairs all = pairs_of(*make_brute_force(), cloth, body);
  ImageSpacePairs detector({.resolution = 512});
  EXPECT_GE(recall(pairs_of(detector, cloth, body), all), kBestRecall);
  EXPECT_EQ(detector.unseen(), 0u);
}

TEST(ImageSpacePairs, WhatIsHiddenFromAllSidesIsMissed) {
  Surface shells = sphere(Vec3::Zero(), 20, 40);  // one inside the other
  const std::size_t n = shells.x_t0.size(), m = shells.triangles.size();
  for (std::size_t i = 0; i < n; ++i) shells.x_t0.push_back(0.5 * shells.x_t0[i]);
  for (std::size_t t = 0; t < m; ++t) {
    Triangle inner = shells.triangles[t];
    for (std::int32_t& v : inner) v += static_cast<std::int32_t>(n);
    shells.triangles.push_back(inner);
  }
  shells.x_t1 = shells.x_t0;
  shells.edges = unique_edges(shells.triangles);
  ImageSpacePairs detector({.resolution = 256});
  const Surface about_inner = sheet(10, 0.2, Vec3(0.4, -0.1, 0.0));
  EXPECT_GT(pairs_of(*make_brute_force(), about_inner, shells).size(), 0u);
  EXPECT_EQ(pairs_of(detector, about_inner, shells).size(), 0u);
  EXPECT_GE(detector.unseen(), m);
}

TEST(ImageSpacePairs, AStaticBodyIsDrawnOnceAndAMovingOneEachTime) {
  Surface body = torus(40, 20);
  Surface cloth = wrapped_on(body, 12, 0.01);
  ImageSpacePairs detector({.resolution = 128});
  body.static_id = 4;
  const CandidatePairs first = pairs_of(detector, cloth, body);
  EXPECT_TRUE(same(first, pairs_of(detector, cloth, body)));
  for (Vec3& x : cloth.x_t1) x[2] += 0.001;
  pairs_of(detector, cloth, body);
  EXPECT_EQ(detector.renders(), 1u);
  body.static_id = 0;
  pairs_of(detector, cloth, body);
  EXPECT_EQ(detector.renders(), 1u) << "no promise, but no motion either";
  for (int step = 0; step < 3; ++step) {
    for (Vec3& x : body.x_t1) x += Vec3(0.0, 0.01, 0.02);
    const CandidatePairs found = pairs_of(detector, cloth, body);
    EXPECT_GT(recall(found, pairs_of(*make_brute_force(), cloth, body)), 0.99);
    body.x_t0 = body.x_t1;
  }
  EXPECT_EQ(detector.renders(), 4u);
}

TEST(ImageSpacePairs, TheStaticOneOfTwoSurfacesIsDrawnWhereverItStands) {
  Surface body = torus(40, 20);
  const Surface cloth = wrapped_on(body, 12, 0.01);
  body.static_id = 4;
  ImageSpacePairs detector({.resolution = 256}), turned({.resolution = 256});
  const CandidatePairs ab = pairs_of(detector, cloth, body), ba = pairs_of(turned, body, cloth);
  EXPECT_GT(ab.size(), 0u);
  EXPECT_GE(recall(ba, pairs_of(*make_brute_force(), body, cloth)), kBestRecall);
  EXPECT_EQ(ab.point_triangle, ba.triangle_point);
  EXPECT_EQ(ab.triangle_point, ba.point_triangle);
  ASSERT_EQ(ab.edge_edge.size(), ba.edge_edge.size());
  for (EdgeEdgePair pair : ab.edge_edge) {
    std::swap(pair.edge_a, pair.edge_b);
    EXPECT_TRUE(std::binary_search(ba.edge_edge.begin(), ba.edge_edge.end(), pair));
  }
}

TEST(ImageSpacePairs, ASpikeCoarsensNothing) {
  Surface body = torus(60, 30);
  Surface cloth = wrapped_on(body, 20, 0.01);
  ImageSpacePairs detector({.resolution = 256});
  body.x_t1[100] += Vec3(1.0, -300.0, 1000.0);
  cloth.x_t1[50] += Vec3(-1.0, 300.0, 1000.0);
  EXPECT_GE(recall(pairs_of(detector, cloth, body), pairs_of(*make_brute_force(), cloth, body)),
            kBestRecall);
}

TEST(ImageSpacePairs, FarFromTheOriginItSeesTheSame) {
  Surface body = torus(60, 30);
  Surface cloth = wrapped_on(body, 20, 0.01);
  for (Surface* s : {&body, &cloth})
    for (auto* xs : {&s->x_t0, &s->x_t1})
      for (Vec3& x : *xs) x += Vec3(1e6, -1e6, 1e6);
  ImageSpacePairs detector({.resolution = 512});
  EXPECT_GE(recall(pairs_of(detector, cloth, body), pairs_of(*make_brute_force(), cloth, body)),
            kBestRecall);
}

TEST(ImageSpacePairs, TheSamePairsTwiceAndForAnyNumberOfThreads) {
  const Surface body = torus(60, 30);
  const Surface cloth = wrapped_on(body, 30, 0.01);
  ImageSpacePairs once({.resolution = 100});
  const CandidatePairs pairs = pairs_of(once, cloth, body);
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    ImageSpacePairs again({.resolution = 100});
    EXPECT_TRUE(same(pairs, pairs_of(again, cloth, body)));
  }
}

TEST(ImageSpacePairs, PassesTheConformanceKitAsAnApproximateDetector) {
  ConformanceConfig config;
  config.scenes = 60;
  const auto report = check_conformance(
      [] { return std::make_unique<ImageSpacePairs>(ImageSpacePairsConfig{256}); }, config);
  EXPECT_TRUE(report.passed()) << report.summary();
  EXPECT_GT(report.calls, 200u);
  std::printf("%s\n", report.summary().c_str());
}

TEST(ImageSpacePairs, BadInputIsRefusedInOneSentence) {
  EXPECT_NE(refusal([] { ImageSpacePairs({.resolution = 8}); }).find("8 texels"),
            std::string::npos);
  EXPECT_NE(refusal([] { ImageSpacePairs({.resolution = 8192}); }).find("8192 texels"),
            std::string::npos);
  ImageSpacePairs detector({.resolution = 64});
  CandidatePairs out;
  const Surface cloth = sheet(4, 1.0, Vec3::Zero());
  EXPECT_NE(refusal([&] { detector.find_self_pairs(cloth.view(), out); }).find("with itself"),
            std::string::npos);
  Surface body = torus(20, 10);
  body.x_t0[33][2] = std::numeric_limits<double>::infinity();
  EXPECT_NE(refusal([&] { pairs_of(detector, cloth, body); }).find("second surface: vertex 33"),
            std::string::npos);
  body = torus(20, 10);
  EXPECT_GT(pairs_of(detector, cloth, body).size(), 0u) << "and can be used on";
  EXPECT_EQ(pairs_of(detector, cloth, {}).size(), 0u);
  EXPECT_EQ(pairs_of(detector, {}, body).size(), 0u);
  detector.set_budget({.pairs = 3});
  EXPECT_THROW(pairs_of(detector, cloth, body), BudgetExceeded);
}

}  // namespace

}  // namespace selvedge::image_space_test
