// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/compare/detectors/conformance.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/base/types.h>

#include <cmath>
#include <ctime>
#include <limits>
#include <random>
#include <set>
#include <stdexcept>

#include "broad_phase_trial.h"

namespace selvedge::broadphase_test {
namespace {

using Surface = OwnedSurface;

void jiggle(Surface& s, Random& random, double amount) {
  for (std::size_t i = 0; i < s.x_t0.size(); ++i) s.x_t1[i] = s.x_t0[i] + random.vector(amount);
}

/// Folds a sheet into a small box: many layers, many pairs.
void crumple(Surface& s, Random& random, double box) {
  for (Vec3& x : s.x_t0)
    for (int k = 0; k < 3; ++k) {
      const double turn =
          std::abs(std::remainder(x[k] * (1.0 + 0.3 * k) + x[(k + 1) % 3], 2 * box));
      x[k] = turn + random.uniform(0.0, 0.05 * box);
    }
  s.x_t1 = s.x_t0;
}

template <class Pair>
bool strictly_sorted(const std::vector<Pair>& pairs) {
  return std::adjacent_find(pairs.begin(), pairs.end(), std::greater_equal<Pair>()) == pairs.end();
}

}  // namespace

TEST(BruteForce, FindsPairsThatTouchAndLeavesOutThoseThatShareAVertex) {
  Surface s;
  s.x_t0 = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}};
  s.triangles = {{0, 1, 2}, {1, 3, 2}, {4, 5, 6}};
  s.close();
  auto detector = make_brute_force();
  CandidatePairs pairs = self_pairs_of(*detector, s);
  // Vertex 3 lies in the box of triangle 0, vertex 0 in that of triangle 1; the third is far away.
  EXPECT_EQ(pairs.point_triangle, (std::vector<PointTrianglePair>{{0, 1}, {3, 0}}));
  // Edges: 01 02 12 13 23 45 46 56. 01-23 and 02-13 do not touch; none else is without a vertex in
  // common.
  EXPECT_TRUE(pairs.edge_edge.empty());
  s.thickness = 2.0;  // Each side: the gap of four is just closed.
  pairs = self_pairs_of(*detector, s);
  // Beside those two: vertices 4 and 6 with both triangles, vertices 1 and 3 with the third.
  EXPECT_EQ(pairs.point_triangle.size(), 8u);
  EXPECT_TRUE(pairs.triangle_point.empty());
}

TEST(BruteForce, SweepsOverTheWholeStep) {
  Surface a = flat_sheet(1, 1, 1.0), b = flat_sheet(1, 1, 1.0);
  for (Vec3& x : b.x_t0) x += Vec3(0, 0, 1);
  for (Vec3& x : b.x_t1) x += Vec3(0, 0, -1);
  auto detector = make_brute_force();
  EXPECT_GT(pairs_of(*detector, a, b).size(), 0u);
  b.x_t1 = b.x_t0;
  EXPECT_EQ(pairs_of(*detector, a, b).size(), 0u);
}

/// conformance_test.cpp has the registered ones; the processor chooses the width there.
TEST(Bvh, FindsWhatBruteForceFindsWithNarrowVectors) {
  const auto make = [] { return make_bvh_aabb({.wide_vectors = false}); };
  const ConformanceReport report = check_conformance(make, {.scenes = 300, .touching = {}});
  EXPECT_TRUE(report.passed()) << report.summary();
}

TEST(Bvh, TakesEdgesThatComeTwiceOrAreOneVertex) {
  Random random(8);
  Surface s = flat_sheet(6, 6, 1.0);
  for (int i = 0; i < 40; ++i) s.edges.push_back({random.integer(0, 48), random.integer(0, 48)});
  s.edges.insert(s.edges.end(), 20, s.edges.front());
  s.thickness = 0.02;
  auto detector = make_bvh_aabb(), brute = make_brute_force();
  EXPECT_TRUE(same(self_pairs_of(*detector, s), self_pairs_of(*brute, s)));
}

TEST(Bvh, ListsAreSortedAndFreeOfDuplicates) {
  Random random(3);
  Surface s = flat_sheet(40, 40, 1.0);
  crumple(s, random, 0.1);
  auto detector = make_bvh_aabb();
  const CandidatePairs pairs = self_pairs_of(*detector, s);
  ASSERT_GT(pairs.edge_edge.size(), 10000u);
  EXPECT_TRUE(strictly_sorted(pairs.point_triangle));
  EXPECT_TRUE(strictly_sorted(pairs.edge_edge));
  for (const EdgeEdgePair& p : pairs.edge_edge) ASSERT_LT(p.edge_a, p.edge_b);
}

TEST(Bvh, FindsTheSameWithAnyNumberOfThreads) {
  Random random(4);
  Surface a = flat_sheet(45, 45, 1.0), b = flat_sheet(40, 40, 1.0);
  crumple(a, random, 0.2);
  crumple(b, random, 0.25);
  jiggle(a, random, 0.005);
  auto brute = make_brute_force();
  const CandidatePairs self = self_pairs_of(*brute, a), pairs = pairs_of(*brute, a, b);
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    auto detector = make_bvh_aabb();
    for (int call = 0; call < 2; ++call) {
      EXPECT_TRUE(same(self_pairs_of(*detector, a), self)) << threads << " threads";
      EXPECT_TRUE(same(pairs_of(*detector, a, b), pairs)) << threads << " threads";
    }
  }
}

TEST(Bvh, ARefittedTreeFindsWhatAFreshOneFinds) {
  Random random(5);
  Surface a = flat_sheet(24, 18, 1.0), b = flat_sheet(12, 12, 1.0);
  a.thickness = 0.004;
  auto kept = make_bvh_aabb(), brute = make_brute_force();
  int refits = 0;
  for (int step = 0; step < 40; ++step) {
    a.x_t0 = a.x_t1;
    jiggle(a, random, step < 20 ? 0.003 : 0.2);
    for (Vec3& x : b.x_t1) x.z() += 0.001;
    if (step == 30) a.x_t1[7] *= 1e4;
    ASSERT_TRUE(same(pairs_of(*kept, a, b), pairs_of(*brute, a, b))) << "step " << step;
    refits += kept->last_cost().refit_s > 0.0 && kept->last_cost().build_s == 0.0;
    ASSERT_TRUE(same(self_pairs_of(*kept, a), self_pairs_of(*brute, a))) << "step " << step;
  }
  EXPECT_GT(refits, 15);
}

TEST(Bvh, ATreeThatHasLostItsShapeIsBuiltAnew) {
  Random random(6);
  Surface a = flat_sheet(20, 20, 1.0);
  auto detector = make_bvh_aabb();
  self_pairs_of(*detector, a);
  for (Vec3& x : a.x_t1) x = random.vector(1.0);
  a.x_t0 = a.x_t1;
  self_pairs_of(*detector, a);
  EXPECT_GT(detector->last_cost().build_s, 0.0);
  self_pairs_of(*detector, a);
  EXPECT_EQ(detector->last_cost().build_s, 0.0);
}

TEST(Bvh, SurfacesMayComeInAnyOrderAndNumber) {
  std::vector<std::unique_ptr<ConformanceScene>> scenes;
  for (std::uint64_t seed = 24; seed < 36; ++seed)
    scenes.push_back(std::make_unique<ConformanceScene>(seed));
  auto kept = make_bvh_aabb(), brute = make_brute_force();
  Random random(7);
  CandidatePairs found, right;
  for (int call = 0; call < 300; ++call) {
    const SurfaceView a = scenes[random.integer(0, 11)]->a();
    const SurfaceView b = scenes[random.integer(0, 11)]->a();  // Often the very same one.
    kept->find_pairs(a, b, found);
    brute->find_pairs(a, b, right);
    ASSERT_TRUE(same(found, right)) << "call " << call;
  }
}

TEST(Bvh, TheSameArraysWithOtherTrianglesAreNoticed) {
  Surface s = flat_sheet(10, 10, 1.0);
  s.thickness = 0.01;
  auto kept = make_bvh_aabb(), brute = make_brute_force();
  self_pairs_of(*kept, s);
  for (Triangle& t : s.triangles) t = {t[0] / 2, t[1] / 2 + 30, t[2] / 3 + 70};
  const std::vector<Edge> edges = unique_edges(s.triangles);
  for (std::size_t i = 0; i < s.edges.size(); ++i) s.edges[i] = edges[i % edges.size()];
  EXPECT_TRUE(same(self_pairs_of(*kept, s), self_pairs_of(*brute, s)));
}

TEST(Bvh, AStaticSurfaceIsKeptUntilItsIdChanges) {
  Surface cloth = flat_sheet(30, 30, 1.0), body = flat_sheet(20, 20, 1.0);
  body.static_id = 77;
  cloth.thickness =
      0.0103;  // No box just touches another, so nothing is looked at again in double.
  auto kept = make_bvh_aabb(), brute = make_brute_force();
  CandidatePairs first = pairs_of(*kept, cloth, body);
  EXPECT_TRUE(same(first, pairs_of(*brute, cloth, body)));
  // The promise is believed: the numbers are not read again.
  for (Vec3& x : body.x_t0) x.z() += 10.0;
  for (Vec3& x : body.x_t1) x.z() += 10.0;
  EXPECT_TRUE(same(pairs_of(*kept, cloth, body), first));
  body.static_id = 78;
  EXPECT_EQ(pairs_of(*kept, cloth, body).size(), 0u);
  body.static_id = 0;
  for (Vec3& x : body.x_t0) x.z() -= 10.0;
  for (Vec3& x : body.x_t1) x.z() -= 10.0;
  EXPECT_TRUE(same(pairs_of(*kept, cloth, body), first));
}

TEST(Bvh, AStaticSurfaceCostsNothingAndFollowsThicknessAndOrigin) {
  Surface cloth = flat_sheet(30, 30, 1.0), body = flat_sheet(20, 20, 1.0);
  cloth.static_id = 5;
  body.static_id = 6;
  for (Vec3& x : body.x_t0) x.z() += 0.1;
  body.x_t1 = body.x_t0;
  auto kept = make_bvh_aabb(), brute = make_brute_force();
  EXPECT_EQ(pairs_of(*kept, cloth, body).size(), 0u);
  pairs_of(*kept, cloth, body);
  EXPECT_EQ(kept->last_cost().build_s, 0.0);
  EXPECT_LT(kept->last_cost().refit_s, 1e-4);
  body.thickness = 0.1;
  EXPECT_TRUE(same(pairs_of(*kept, cloth, body), pairs_of(*brute, cloth, body)));
  EXPECT_GT(pairs_of(*kept, cloth, body).size(), 0u);
  // A moving surface goes far away and drags the origin along; then it comes back.
  cloth.static_id = 0;
  for (const double shift : {1e5, -1e5}) {
    for (auto* xs : {&cloth.x_t0, &cloth.x_t1})
      for (Vec3& x : *xs) x.x() += shift;
    EXPECT_TRUE(same(pairs_of(*kept, cloth, body), pairs_of(*brute, cloth, body)));
  }
  EXPECT_GT(pairs_of(*kept, cloth, body).size(), 0u);
}

TEST(BroadPhases, EmptySurfacesHaveNoPairs) {
  for (const auto& [name, make] : broad_phases()) {
    auto detector = make();
    const Surface none, some = flat_sheet(3, 3, 1.0);
    if (detector->traits().self) {
      EXPECT_EQ(self_pairs_of(*detector, none).size(), 0u) << name;
    }
    EXPECT_EQ(pairs_of(*detector, none, some).size(), 0u) << name;
    EXPECT_EQ(pairs_of(*detector, some, none).size(), 0u) << name;
  }
}

TEST(BroadPhases, StopLongBeforeTheMemoryIsFull) {
  Surface s = flat_sheet(120, 120, 1.0);  // All in one point: 1.3·10^9 pairs.
  for (Vec3& x : s.x_t0) x = Vec3(1, 2, 3);
  s.x_t1 = s.x_t0;
  auto detector = make_bvh_aabb();
  detector->set_budget({.bytes = 40'000'000});
  CandidatePairs out;
  EXPECT_THROW(detector->find_self_pairs(s.view(), out), BudgetExceeded);
  EXPECT_LT(detector->last_cost().bytes, 40'000'000u);
}

TEST(BroadPhases, SpikesStayCheap) {
  Surface cloth = flat_sheet(100, 100, 1.0);
  cloth.thickness = 0.001;
  for (int spike = 0; spike < 20; ++spike) cloth.x_t1[500 * spike + 57] += Vec3(1e3, 1e3, 1e3);
  auto detector = make_bvh_aabb();
  CandidatePairs pairs;
  const std::clock_t start =
      std::clock();  // processor time, because other tests run beside this one
  detector->find_self_pairs(cloth.view(), pairs);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  EXPECT_GT(pairs.size(), 100000u);  // A spike's box covers a quarter of the cloth or more.
  EXPECT_LT(seconds, 2.0);
}

}  // namespace selvedge::broadphase_test
