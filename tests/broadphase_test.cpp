// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/core/parallel.h>
#include <selvedge/core/triangle_mesh.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <stdexcept>

using namespace selvedge;

namespace {

/// A surface that owns its arrays.
struct Surface {
  std::vector<Vec3> x_t0, x_t1;
  std::vector<Edge> edges;
  std::vector<Triangle> triangles;
  double thickness = 0.0;
  std::uint64_t static_id = 0;

  SurfaceView view() const { return {x_t0, x_t1, edges, triangles, thickness, static_id}; }
  void close() {
    x_t1 = x_t0;
    edges = unique_edges(triangles);
  }
};

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform(double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(engine_);
  }
  int integer(int lo, int hi) { return std::uniform_int_distribution<int>(lo, hi)(engine_); }
  Vec3 vector(double r) { return {uniform(-r, r), uniform(-r, r), uniform(-r, r)}; }

 private:
  std::mt19937 engine_;
};

Surface grid(int nx, int ny, double size) {
  Surface s;
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) s.x_t0.push_back({size * i / nx, size * j / ny, 0.0});
  const auto at = [nx](int i, int j) { return j * (nx + 1) + i; };
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      s.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      s.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  s.close();
  return s;
}

/// Triangles on random vertices; some vertices in no triangle, some triangles with shared ones.
Surface soup(Random& random, int vertices, int triangles, double reach) {
  Surface s;
  for (int i = 0; i < vertices; ++i) s.x_t0.push_back(random.vector(1.0));
  for (int i = 0; i < triangles && vertices >= 3; ++i) {
    const int a = random.integer(0, vertices - 1);
    const auto near = [&](int step) { return (a + step) % vertices; };
    const int b = random.integer(1, 2);
    s.triangles.push_back({a, near(b), near(b + 1)});
    if (vertices == 3) break;
  }
  if (reach < 1.0)  // Neighbours in index become neighbours in space.
    for (int i = 1; i < vertices; ++i)
      if (i % 17) s.x_t0[i] = s.x_t0[i - 1] + random.vector(reach);
  s.close();
  return s;
}

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

/// A random scene of one of several kinds, most of them nasty.
Surface make_scene(unsigned seed) {
  Random random(seed);
  Surface s;
  const int n = random.integer(1, 12);
  switch (seed % 12) {
    case 0:
      s = soup(random, random.integer(0, 40), random.integer(0, 60), 1.0);
      break;
    case 1:
      s = soup(random, 150, 150, 0.05);
      jiggle(s, random, 0.05);
      break;
    case 2:
      s = grid(n, 12, 1.0);
      jiggle(s, random, 0.1);
      break;
    case 3:
      s = grid(12, 12, 1.0);
      crumple(s, random, 0.2);
      jiggle(s, random, 0.01);
      break;
    case 4:  // A spike.
      s = grid(12, 12, 1.0);
      s.x_t1[random.integer(0, 168)] +=
          Vec3(random.uniform(-10, 10), 3, 1000 * random.uniform(0, 1));
      break;
    case 5:  // Everything in one point.
      s = grid(5, 5, 1.0);
      for (Vec3& x : s.x_t0) x = Vec3(0.3, 0.1, -7.0);
      s.x_t1 = s.x_t0;
      break;
    case 6:  // Exact touches everywhere: integer coordinates, no thickness.
      s = soup(random, 40, 60, 1.0);
      for (Vec3& x : s.x_t0) x = (3.0 * x).array().round();
      s.x_t1 = s.x_t0;
      return s;
    case 7:  // Far from the origin.
      s = grid(12, 12, 1.0);
      crumple(s, random, 0.2);
      jiggle(s, random, 0.01);
      for (auto* xs : {&s.x_t0, &s.x_t1})
        for (Vec3& x : *xs) x += Vec3(1e6, -1e6, 1e6);
      break;
    case 8:  // Points and edges that belong to no triangle.
      s = soup(random, 60, 30, 0.3);
      for (int i = 0; i < 20; ++i)
        s.edges.push_back({random.integer(0, 59), random.integer(0, 59)});
      jiggle(s, random, 0.1);
      break;
    case 9:  // One triangle.
      s = grid(1, 1, 1.0);
      s.triangles.resize(1);
      s.close();
      break;
    case 10:  // Sizes over many orders of magnitude, up to where squares overflow a float.
      s = soup(random, 80, 80, 1.0);
      for (Vec3& x : s.x_t0) x *= std::pow(10.0, random.integer(-30, 200));
      s.close();
      break;
    default:  // A fan: one vertex in all triangles.
      for (int i = 0; i < 60; ++i) s.x_t0.push_back(random.vector(1.0));
      for (int i = 1; i + 1 < 60; ++i) s.triangles.push_back({0, i, i + 1});
      s.close();
      break;
  }
  s.thickness = random.integer(0, 2) * 0.01;
  return s;
}

CandidatePairs pairs_of(BroadPhase& detector, const Surface& a, const Surface& b) {
  CandidatePairs out;
  detector.find_pairs(a.view(), b.view(), out);
  return out;
}

CandidatePairs self_pairs_of(BroadPhase& detector, const Surface& a) {
  CandidatePairs out;
  detector.find_self_pairs(a.view(), out);
  return out;
}

::testing::AssertionResult same(const CandidatePairs& a, const CandidatePairs& b) {
  if (a.point_triangle == b.point_triangle && a.triangle_point == b.triangle_point &&
      a.edge_edge == b.edge_edge)
    return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << a.point_triangle.size() << "/" << a.triangle_point.size() << "/" << a.edge_edge.size()
         << " pairs against " << b.point_triangle.size() << "/" << b.triangle_point.size() << "/"
         << b.edge_edge.size();
}

template <class Pair>
bool strictly_sorted(const std::vector<Pair>& pairs) {
  return std::adjacent_find(pairs.begin(), pairs.end(), std::greater_equal<Pair>()) == pairs.end();
}

std::string message_of(BroadPhase& detector, const Surface& a) {
  try {
    self_pairs_of(detector, a);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
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
  Surface a = grid(1, 1, 1.0), b = grid(1, 1, 1.0);
  for (Vec3& x : b.x_t0) x += Vec3(0, 0, 1);
  for (Vec3& x : b.x_t1) x += Vec3(0, 0, -1);
  auto detector = make_brute_force();
  EXPECT_GT(pairs_of(*detector, a, b).size(), 0u);
  b.x_t1 = b.x_t0;
  EXPECT_EQ(pairs_of(*detector, a, b).size(), 0u);
}

TEST(Bvh, FindsWhatBruteForceFindsOnRandomAndNastySurfaces) {
  auto brute = make_brute_force();
  std::size_t found = 0;
  for (const bool wide : {false, true}) {
    auto kept = make_bvh_aabb({.wide_vectors = wide});
    for (unsigned seed = 0; seed < 600; ++seed) {
      const Surface a = make_scene(seed), b = make_scene(seed * 7 + 5);
      const CandidatePairs self = self_pairs_of(*brute, a);
      const CandidatePairs pairs = pairs_of(*brute, a, b);
      ASSERT_TRUE(same(self_pairs_of(*kept, a), self)) << "seed " << seed;
      ASSERT_TRUE(same(pairs_of(*kept, a, b), pairs)) << "seed " << seed;
      auto fresh = make_bvh_aabb({.wide_vectors = wide});
      ASSERT_TRUE(same(pairs_of(*fresh, a, b), pairs)) << "seed " << seed;
      found += self.size() + pairs.size();
    }
  }
  EXPECT_GT(found, 500000u);
}

TEST(Bvh, ListsAreSortedAndFreeOfDuplicates) {
  Random random(3);
  Surface s = grid(40, 40, 1.0);
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
  Surface a = grid(45, 45, 1.0), b = grid(40, 40, 1.0);
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
  Surface a = grid(24, 18, 1.0), b = grid(12, 12, 1.0);
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
  Surface a = grid(20, 20, 1.0);
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
  std::vector<Surface> surfaces;
  for (unsigned seed = 24; seed < 36; ++seed) surfaces.push_back(make_scene(seed));
  auto kept = make_bvh_aabb(), brute = make_brute_force();
  Random random(7);
  for (int call = 0; call < 300; ++call) {
    const Surface& a = surfaces[random.integer(0, 11)];
    const Surface& b = surfaces[random.integer(0, 11)];  // Often the very same one.
    ASSERT_TRUE(same(pairs_of(*kept, a, b), pairs_of(*brute, a, b))) << "call " << call;
  }
}

TEST(Bvh, TheSameArraysWithOtherTrianglesAreNoticed) {
  Surface s = grid(10, 10, 1.0);
  s.thickness = 0.01;
  auto kept = make_bvh_aabb(), brute = make_brute_force();
  self_pairs_of(*kept, s);
  for (Triangle& t : s.triangles) t = {t[0] / 2, t[1] / 2 + 30, t[2] / 3 + 70};
  const std::vector<Edge> edges = unique_edges(s.triangles);
  for (std::size_t i = 0; i < s.edges.size(); ++i) s.edges[i] = edges[i % edges.size()];
  EXPECT_TRUE(same(self_pairs_of(*kept, s), self_pairs_of(*brute, s)));
}

TEST(Bvh, AStaticSurfaceIsKeptUntilItsIdChanges) {
  Surface cloth = grid(30, 30, 1.0), body = grid(20, 20, 1.0);
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
  Surface cloth = grid(30, 30, 1.0), body = grid(20, 20, 1.0);
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

TEST(BroadPhases, NameTheVertexThatIsNotFinite) {
  for (const auto& [name, make] : broad_phases()) {
    auto detector = make();
    Surface s = grid(20, 20, 1.0);
    self_pairs_of(*detector, s);
    s.x_t1[137].y() = std::nan("");
    EXPECT_NE(message_of(*detector, s).find("vertex 137"), std::string::npos) << name;
    s.x_t1[137].y() = 0.0;
    s.x_t0[440].x() = -std::numeric_limits<double>::infinity();
    EXPECT_NE(message_of(*detector, s).find("vertex 440"), std::string::npos) << name;
    Surface good = grid(2, 2, 1.0);
    EXPECT_THROW(pairs_of(*detector, good, s), std::invalid_argument) << name;
    EXPECT_THROW(pairs_of(*detector, s, good), std::invalid_argument) << name;
    s.x_t0[440].x() = 1.0;
    EXPECT_EQ(message_of(*detector, s), "") << name;
  }
}

TEST(BroadPhases, RefuseIndicesOutOfRangeUnequalLengthsAndBadThickness) {
  for (const auto& [name, make] : broad_phases()) {
    auto detector = make();
    Surface s = grid(3, 3, 1.0);
    s.triangles[4][1] = 16;
    EXPECT_NE(message_of(*detector, s).find("triangle 4 names vertex 16 of 16"), std::string::npos);
    s = grid(3, 3, 1.0);
    s.edges[5][0] = -1;
    EXPECT_NE(message_of(*detector, s).find("edge 5 names vertex -1 of 16"), std::string::npos);
    s = grid(3, 3, 1.0);
    s.x_t1.pop_back();
    EXPECT_NE(message_of(*detector, s), "") << name;
    s = grid(3, 3, 1.0);
    s.thickness = -1e-3;
    EXPECT_NE(message_of(*detector, s).find("thickness"), std::string::npos) << name;
    s.thickness = std::nan("");
    EXPECT_NE(message_of(*detector, s).find("thickness"), std::string::npos) << name;
  }
}

TEST(BroadPhases, EmptySurfacesHaveNoPairs) {
  for (const auto& [name, make] : broad_phases()) {
    auto detector = make();
    const Surface none, some = grid(3, 3, 1.0);
    EXPECT_EQ(self_pairs_of(*detector, none).size(), 0u) << name;
    EXPECT_EQ(pairs_of(*detector, none, some).size(), 0u) << name;
    EXPECT_EQ(pairs_of(*detector, some, none).size(), 0u) << name;
  }
}

TEST(BroadPhases, StopAtTheirBudgetAndGoOn) {
  Surface a = grid(20, 20, 1.0), b = grid(17, 17, 1.0);
  a.thickness = 0.05;
  auto brute = make_brute_force();
  const CandidatePairs self = self_pairs_of(*brute, a), pairs = pairs_of(*brute, a, b);
  for (const auto& [name, make] : broad_phases())
    for (const int threads : {1, 2, 8}) {
      const ThreadLimit limit(threads);
      auto detector = make();
      CandidatePairs out = pairs;
      detector->set_budget({.pairs = self.size() - 1});
      EXPECT_THROW(detector->find_self_pairs(a.view(), out), BudgetExceeded) << name;
      EXPECT_EQ(out.size(), 0u) << name;
      detector->set_budget({.pairs = self.size()});
      EXPECT_TRUE(same(self_pairs_of(*detector, a), self)) << name;
      out = self;
      detector->set_budget({.bytes = pairs.size()});
      EXPECT_THROW(detector->find_pairs(a.view(), b.view(), out), BudgetExceeded) << name;
      EXPECT_EQ(out.size(), 0u) << name;
      detector->set_budget({});
      EXPECT_TRUE(same(pairs_of(*detector, a, b), pairs)) << name;
    }
}

TEST(BroadPhases, StopLongBeforeTheMemoryIsFull) {
  Surface s = grid(120, 120, 1.0);  // All in one point: 1.3·10^9 pairs.
  for (Vec3& x : s.x_t0) x = Vec3(1, 2, 3);
  s.x_t1 = s.x_t0;
  auto detector = make_bvh_aabb();
  detector->set_budget({.bytes = 40'000'000});
  CandidatePairs out;
  EXPECT_THROW(detector->find_self_pairs(s.view(), out), BudgetExceeded);
  EXPECT_LT(detector->last_cost().bytes, 40'000'000u);
}

TEST(BroadPhases, SpikesStayCheap) {
  Surface cloth = grid(100, 100, 1.0);
  cloth.thickness = 0.001;
  for (int spike = 0; spike < 20; ++spike) cloth.x_t1[500 * spike + 57] += Vec3(1e3, 1e3, 1e3);
  auto detector = make_bvh_aabb();
  CandidatePairs pairs;
  detector->find_self_pairs(cloth.view(), pairs);
  const double seconds = detector->last_cost().build_s + detector->last_cost().query_s;
  EXPECT_GT(pairs.size(), 100000u);  // A spike's box covers a quarter of the cloth or more.
  EXPECT_LT(seconds, 2.0);
}
