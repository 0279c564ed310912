// SPDX-License-Identifier: MIT
// The curvature cone in the shadow of the tree that it culls: whatever it leaves out must keep
// farther apart than the two thicknesses during the whole step.
#include <gtest/gtest.h>
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/base/types.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/distance.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numbers>
#include <random>

#include "owned_surface.h"

namespace selvedge::curvature_cone_test {
namespace {

using Surface = OwnedSurface;

/// A grid of nx x ny cells whose point (u, v), both in [0, 1], lies at shape(u, v); at rest.
Surface sheet(int nx, int ny, double thickness, const std::function<Vec3(double, double)>& shape) {
  Surface s;
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i)
      s.x_t0.push_back(shape(static_cast<double>(i) / nx, static_cast<double>(j) / ny));
  const auto at = [nx](int i, int j) { return j * (nx + 1) + i; };
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      s.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      s.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  s.x_t1 = s.x_t0;
  s.edges = unique_edges(s.triangles);
  s.thickness = thickness;
  return s;
}

Vec3 flat(double u, double v) { return {u, v, 0.0}; }

/// `turns` turns of a ramp about z: all its normals point upwards.
Surface ramp(double turns, double pitch, double thickness) {
  return sheet(64, 6, thickness, [=](double u, double v) {
    const double angle = 2.0 * std::numbers::pi * turns * u, r = 0.5 + 0.5 * v;
    return Vec3(r * std::cos(angle), r * std::sin(angle), pitch * turns * u);
  });
}

CandidatePairs self_pairs(const std::unique_ptr<BroadPhase>& detector, const Surface& s) {
  CandidatePairs pairs;
  detector->find_self_pairs(s.view(), pairs);
  return pairs;
}

template <class Pair>
std::vector<Pair> minus(const std::vector<Pair>& a, const std::vector<Pair>& b) {
  std::vector<Pair> rest;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(rest));
  return rest;
}

/// Distance of a pair's primitives at time t.
double distance_at(const Surface& s, const PointTrianglePair& p, double t) {
  const auto x = [&](std::int32_t v) { return Vec3((1.0 - t) * s.x_t0[v] + t * s.x_t1[v]); };
  const Triangle& c = s.triangles[p.triangle];
  return point_triangle_closest(x(p.point), x(c[0]), x(c[1]), x(c[2])).distance;
}
double distance_at(const Surface& s, const EdgeEdgePair& p, double t) {
  const auto x = [&](std::int32_t v) { return Vec3((1.0 - t) * s.x_t0[v] + t * s.x_t1[v]); };
  const Edge &a = s.edges[p.edge_a], &b = s.edges[p.edge_b];
  return edge_edge_closest(x(a[0]), x(a[1]), x(b[0]), x(b[1])).distance;
}

/// Pairs that the cone leaves out; fails the test for one that may touch or come near.
std::size_t check_shadow(const Surface& s, const std::string& what) {
  const CandidatePairs all = self_pairs(make_bvh_aabb(), s);
  const CandidatePairs kept = self_pairs(make_curvature_cone(), s);
  EXPECT_TRUE(minus(kept.point_triangle, all.point_triangle).empty()) << what;
  EXPECT_TRUE(minus(kept.edge_edge, all.edge_edge).empty()) << what;
  CandidatePairs out;
  out.point_triangle = minus(all.point_triangle, kept.point_triangle);
  out.edge_edge = minus(all.edge_edge, kept.edge_edge);
  std::vector<Contact> contacts;
  make_ccd_exact()->find_contacts(s.view(), s.view(), out, contacts);
  EXPECT_TRUE(contacts.empty()) << what << ": " << contacts.size() << " collisions left out";
  double nearest = 1e300;
  for (int k = 0; k <= 16; ++k) {
    for (const auto& p : out.point_triangle)
      nearest = std::min(nearest, distance_at(s, p, k / 16.0));
    for (const auto& p : out.edge_edge) nearest = std::min(nearest, distance_at(s, p, k / 16.0));
  }
  EXPECT_GT(nearest, 2.0 * s.thickness) << what;
  return out.size();
}

TEST(CurvatureCone, AFlatSheetHasNoPairsWithItself) {
  const Surface s = sheet(40, 40, 0.004, flat);
  EXPECT_GT(self_pairs(make_bvh_aabb(), s).size(), 10000u);
  EXPECT_EQ(self_pairs(make_curvature_cone(), s).size(), 0u);
  EXPECT_GT(check_shadow(s, "flat"), 10000u);
}

TEST(CurvatureCone, ASheetFinerThanItsThicknessKeepsItsPairs) {
  const Surface s = sheet(40, 40, 0.02, flat);  // cells of 25 mm, layers of 40 mm
  EXPECT_EQ(self_pairs(make_curvature_cone(), s).size(), self_pairs(make_bvh_aabb(), s).size());
}

TEST(CurvatureCone, ARampThatWindsTwiceIsNotTakenForASheet) {
  // Two turns nearer than the thicknesses: the normals are in a narrow cone, the contour is not
  // simple. A third of a turn alone is.
  const Surface s = ramp(2.0, 1e-5, 1e-5);
  const CandidatePairs kept = self_pairs(make_curvature_cone(), s);
  // Each edge of a turn lies on one of the other: there are some 800 of them in a turn.
  EXPECT_GT(kept.edge_edge.size(), 600u);
  check_shadow(s, "ramp");
  EXPECT_EQ(self_pairs(make_curvature_cone(), ramp(0.3, 1e-5, 1e-5)).size(), 0u);
}

TEST(CurvatureCone, TurnsThatPassThroughEachOtherAreAllFound) {
  Surface s = ramp(2.0, 0.02, 1e-5);
  for (std::size_t i = 0; i < s.x_t1.size(); ++i)  // the upper turn falls through the lower one
    s.x_t1[i].z() = s.x_t0[i].z() > 0.02 ? s.x_t0[i].z() - 0.05 : s.x_t0[i].z();
  std::vector<Contact> all, kept;
  const auto exact = make_ccd_exact();
  exact->find_contacts(s.view(), s.view(), self_pairs(make_bvh_aabb(), s), all);
  exact->find_contacts(s.view(), s.view(), self_pairs(make_curvature_cone(), s), kept);
  EXPECT_GT(all.size(), 100u);
  EXPECT_EQ(kept.size(), all.size());
}

TEST(CurvatureCone, ASheetThatFoldsInAStepKeepsItsPairs) {
  Surface s = sheet(12, 12, 1e-3, flat);
  for (Vec3& x : s.x_t1)  // the right half turns over onto the left one
    if (x.x() > 0.5) x = Vec3(1.0 - x.x(), x.y(), 0.02);
  std::vector<Contact> all, kept;
  const auto exact = make_ccd_exact();
  exact->find_contacts(s.view(), s.view(), self_pairs(make_bvh_aabb(), s), all);
  exact->find_contacts(s.view(), s.view(), self_pairs(make_curvature_cone(), s), kept);
  EXPECT_EQ(kept.size(), all.size());
  check_shadow(s, "fold");
}

TEST(CurvatureCone, TheTwoSidesOfASlitStayAPair) {
  // A sheet cut from the middle of one side: contour edges face each other across the cut.
  const int n = 20;
  Surface s = sheet(n, n, 2e-3, flat);
  const auto at = [n](int i, int j) { return j * (n + 1) + i; };
  std::vector<std::int32_t> twin(s.x_t0.size(), -1);
  for (int j = 0; j < n / 2; ++j) {
    twin[at(n / 2, j)] = static_cast<std::int32_t>(s.x_t0.size());
    s.x_t0.push_back(s.x_t0[at(n / 2, j)] + Vec3(1e-3, 0.0, 0.0));
  }
  for (Triangle& t : s.triangles) {
    const double middle = (s.x_t0[t[0]].x() + s.x_t0[t[1]].x() + s.x_t0[t[2]].x()) / 3.0;
    for (std::int32_t& v : t)
      if (middle > 0.5 && v < (n + 1) * (n + 1) && twin[v] >= 0) v = twin[v];
  }
  s.x_t1 = s.x_t0;
  s.edges = unique_edges(s.triangles);
  check_shadow(s, "slit");
  const CandidatePairs kept = self_pairs(make_curvature_cone(), s);
  EXPECT_GT(kept.size(), 0u);
}

TEST(CurvatureCone, NothingThatComesNearIsLeftOutOnRandomSurfaces) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::size_t left_out = 0;
  for (int i = 0; i < 120; ++i) {
    const double bend = 4.0 * unit(random), wave = 0.1 * unit(random), noise = 0.02 * unit(random);
    const double turn = 3.0 * unit(random), motion = 0.1 * unit(random);
    Surface s = sheet(12, 12, std::abs(0.02 * unit(random)), [&](double u, double v) {
      const double a = bend * (u - 0.5), w = wave * std::sin(9.0 * v + turn * u);
      // Rolled up about the y axis, with waves along it.
      const double r = std::abs(bend) > 0.1 ? 1.0 / bend : 10.0;
      return Vec3((r + w) * std::sin(a), v, (r + w) * (1.0 - std::cos(a)));
    });
    for (Vec3& x : s.x_t0) x += noise * Vec3(unit(random), unit(random), unit(random));
    for (std::size_t k = 0; k < s.x_t0.size(); ++k)
      s.x_t1[k] = s.x_t0[k] + motion * Vec3(std::sin(5.0 * s.x_t0[k].y()), unit(random) * 0.1,
                                            std::cos(turn * s.x_t0[k].x()));
    if (i % 4 == 0)
      for (auto* xs : {&s.x_t0, &s.x_t1})
        for (Vec3& x : *xs) x += Vec3(1e6, -1e6, 1e6);
    left_out += check_shadow(s, "surface " + std::to_string(i));
  }
  EXPECT_GT(left_out, 1000u);
}

TEST(CurvatureCone, SeesTheSameForAnyNumberOfThreadsAndAfterARefit) {
  Surface s = sheet(60, 60, 1e-3, [](double u, double v) {
    return Vec3(u, v, 0.15 * std::sin(9.0 * u) * std::cos(7.0 * v));
  });
  const auto detector = make_curvature_cone();
  std::vector<CandidatePairs> found;
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    found.push_back(self_pairs(detector, s));
    found.push_back(self_pairs(make_curvature_cone(), s));
  }
  for (const CandidatePairs& pairs : found) {
    EXPECT_EQ(pairs.point_triangle, found[0].point_triangle);
    EXPECT_EQ(pairs.edge_edge, found[0].edge_edge);
  }
}

TEST(CurvatureCone, LooseEdgesSharedEdgesAndTrianglesThatTurnOtherwiseAreNoObstacle) {
  Surface s = sheet(10, 10, 1e-3, flat);
  s.edges.push_back({0, 120});                        // a side of no triangle
  s.triangles.push_back({0, 1, 120});                 // a third triangle on an edge
  std::swap(s.triangles[50][0], s.triangles[50][1]);  // one that turns the other way
  s.triangles.push_back({5, 5, 6});                   // one without area
  s.edges = unique_edges(s.triangles);
  s.edges.push_back({0, 120});
  check_shadow(s, "faulty");
}

}  // namespace

// The cone of normals alone: what it skips, and what it misses thereby.

TEST(NormalCone, SkipsSurfacesWhoseNormalsLieOnOneSide) {
  const auto part_of_cylinder = [](double turns) {
    return sheet(32, 6, 1e-4, [=](double u, double v) {
      const double angle = 2.0 * std::numbers::pi * turns * (u - 0.5);
      return Vec3(std::cos(angle), std::sin(angle), v);
    });
  };
  EXPECT_EQ(self_pairs(make_normal_cone(), sheet(12, 12, 1e-4, flat)).size(), 0u);
  EXPECT_EQ(self_pairs(make_normal_cone(), part_of_cylinder(0.45)).size(), 0u);
  EXPECT_GT(self_pairs(make_normal_cone(), part_of_cylinder(0.55)).size(), 0u);
}

TEST(NormalCone, MissesARampThatWindsTwice) {
  const Surface s = ramp(2.0, 1e-5, 1e-5);
  EXPECT_EQ(self_pairs(make_normal_cone(), s).size(), 0u);
  EXPECT_GT(self_pairs(make_curvature_cone(), s).size(), 600u);
  EXPECT_EQ(make_normal_cone()->traits().guarantee, Guarantee::approximate);
}

// Opposite normals lie in no cone below a half space, at either end of the step.
TEST(NormalCone, KeepsThePairsOfLayersThatFaceEachOther) {
  for (const bool at_start : {true, false}) {
    Surface s = sheet(12, 12, 1e-3, flat);
    std::vector<Vec3>& folded = at_start ? s.x_t0 : s.x_t1;
    for (Vec3& x : folded)
      if (x.x() > 0.5) x = Vec3(1.0 - x.x(), x.y(), 0.02);
    const auto layer = [&](std::int32_t v) { return s.x_t0[v].z() + s.x_t1[v].z() > 0.0; };
    const auto across = [&](const CandidatePairs& pairs) {
      std::size_t count = 0;
      for (const auto& [point, triangle] : pairs.point_triangle)
        count += layer(point) != layer(s.triangles[triangle][0]) ? 1 : 0;
      return count;
    };
    const CandidatePairs all = self_pairs(make_bvh_aabb(), s);
    EXPECT_GT(across(all), 50u);
    EXPECT_EQ(across(self_pairs(make_normal_cone(), s)), across(all));
  }
}

}  // namespace selvedge::curvature_cone_test
