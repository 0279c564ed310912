// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/box_pairs.h>
#include <selvedge/core/parallel.h>
#include <selvedge/core/triangle_mesh.h>

#include <cmath>
#include <random>

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

/// A flat sheet of n x n squares.
Surface sheet(int n, double size) {
  Surface s;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) s.x_t0.push_back({size * i / n, size * j / n, 0.0});
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      s.triangles.push_back({a, b, d});
      s.triangles.push_back({a, d, c});
    }
  s.x_t1 = s.x_t0;
  s.edges = unique_edges(s.triangles);
  return s;
}

/// Folds a surface into a box, then moves every vertex a little.
Surface crumpled(Surface s, Random& random, double box, double motion) {
  for (std::size_t i = 0; i < s.x_t0.size(); ++i) {
    Vec3& x = s.x_t0[i];
    for (int k = 0; k < 3; ++k)
      x[k] = std::abs(std::remainder(x[k] * (1.0 + 0.3 * k) + x[(k + 1) % 3], 2 * box)) +
             random.uniform(0.0, 0.05 * box);
    s.x_t1[i] = x + random.vector(motion);
  }
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

/// The plainest engine: it shows what the frame asks for, and counts the structures it makes.
struct AllPairsEngine {
  using SweptBox = detail::SweptBox;
  struct Structure {
    const std::vector<SweptBox>* boxes = nullptr;
    std::size_t bytes() const { return 0; }
  };

  int* builds;
  bool keeps = true;

  bool prepare(const detail::SurfaceBoxes&, const detail::SurfaceBoxes*) { return keeps; }
  void build(const std::vector<SweptBox>& boxes, Structure& out) {
    ++*builds;
    out.boxes = &boxes;
  }
  void find_pairs(Structure& a, Structure& b, detail::PairParts& out) {
    find(*a.boxes, *b.boxes, false, out);
  }
  void find_self_pairs(Structure& a, detail::PairParts& out) {
    find(*a.boxes, *a.boxes, true, out);
  }
  std::size_t bytes() const { return 0; }

  /// Backwards and spread over the parts: the frame must sort.
  static void find(const std::vector<SweptBox>& a, const std::vector<SweptBox>& b, bool self,
                   detail::PairParts& out) {
    for (std::size_t i = a.size(); i-- > 0;)
      for (std::size_t j = b.size(); j-- > 0;)
        if ((!self || j < i) && detail::overlap(a[i], b[j]))
          out.add((i + j) % detail::kBoxPairParts, static_cast<std::int32_t>(i),
                  static_cast<std::int32_t>(j));
  }
};

}  // namespace

TEST(BoxPairDetector, MakesBruteForceOfAnyExactEngine) {
  Random random(1);
  auto brute = make_brute_force();
  int builds = 0;
  detail::BoxPairDetector detector({}, AllPairsEngine{&builds});
  for (int scene = 0; scene < 20; ++scene) {
    Surface a = crumpled(sheet(random.integer(1, 9), 1.0), random, 0.3, 0.02);
    Surface b = crumpled(sheet(random.integer(1, 9), 1.0), random, 0.3, 0.02);
    a.thickness = 0.01 * random.integer(0, 2);
    ASSERT_TRUE(same(self_pairs_of(detector, a), self_pairs_of(*brute, a)));
    ASSERT_TRUE(same(pairs_of(detector, a, b), pairs_of(*brute, a, b)));
  }
}

TEST(BoxPairDetector, KeepsTheStructuresOfAStaticSurface) {
  Random random(2);
  Surface cloth = sheet(6, 1.0), body = sheet(5, 1.0);
  body.static_id = 7;
  for (const bool keeps : {true, false}) {
    int builds = 0;
    detail::BoxPairDetector detector({}, AllPairsEngine{&builds, keeps});
    const CandidatePairs first = pairs_of(detector, cloth, body);
    EXPECT_EQ(builds, 6);
    self_pairs_of(detector, cloth);
    pairs_of(detector, cloth, body);
    EXPECT_EQ(builds, keeps ? 12 : 15);
    for (Vec3& x : body.x_t1) x.z() += 5.0;  // The promise is believed.
    for (Vec3& x : body.x_t0) x.z() += 5.0;
    EXPECT_TRUE(same(pairs_of(detector, cloth, body), first));
    body.thickness = 6.0;
    EXPECT_GT(pairs_of(detector, cloth, body).size(), first.size());
    body.static_id = 8;
    body.thickness = 0.0;
    EXPECT_EQ(pairs_of(detector, cloth, body).size(), 0u);
    for (Vec3& x : body.x_t1) x.z() -= 5.0;
    for (Vec3& x : body.x_t0) x.z() -= 5.0;
  }
}
