// SPDX-License-Identifier: MIT
// The minimal enclosure: everything of a body is inside it, and what is dropped outside of it loses
// no pair of boxes that brute force finds, nor any that collides.
#include <gtest/gtest.h>
#include <selvedge/broadphase/internal/minimal_enclosure.h>
#include <selvedge/compare/detectors/conformance.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/base/types.h>
#include <selvedge/data/makers/mannequin.h>
#include <selvedge/narrowphase/narrow_phase.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>

#include "broad_phase_trial.h"

namespace selvedge::minimal_enclosure_test {
namespace {

constexpr double kPi = std::numbers::pi;

/// A surface a millimetre thick, to be moved and put together.
struct Surface : OwnedSurface {
  Surface() { thickness = 0.001; }
  /// Where every vertex is at both times.
  void map(const std::function<Vec3(const Vec3&)>& f) {
    for (auto* xs : {&x_t0, &x_t1})
      for (Vec3& x : *xs) x = f(x);
  }
  void add(const Surface& other) {
    const auto first = static_cast<std::int32_t>(x_t0.size());
    x_t0.insert(x_t0.end(), other.x_t0.begin(), other.x_t0.end());
    for (Triangle t : other.triangles) {
      for (std::int32_t& v : t) v += first;
      triangles.push_back(t);
    }
    close();
  }
};

/// A grid of rows x columns vertices at place(u, v), u and v in [0, 1], in v closed to a ring.
Surface ring_grid(int rows, int columns, const std::function<Vec3(double, double)>& place) {
  Surface s;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j)
      s.x_t0.push_back(
          place(static_cast<double>(i) / (rows - 1), static_cast<double>(j) / columns));
  for (int i = 0; i + 1 < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      const int a = i * columns + j, b = i * columns + (j + 1) % columns;
      s.triangles.push_back({a, b, b + columns});
      s.triangles.push_back({a, b + columns, a + columns});
    }
  s.close();
  return s;
}

/// An open tube along z whose radius goes from r0 to r1.
Surface tube(double r0, double r1, double height, int rows = 40, int columns = 24) {
  return ring_grid(rows, columns, [&](double u, double v) {
    const double r = r0 + (r1 - r0) * u;
    return Vec3(r * std::cos(2 * kPi * v), r * std::sin(2 * kPi * v), height * u);
  });
}

/// A tube that is bent by a quarter of a circle.
Surface bent_tube() {
  return ring_grid(50, 20, [](double u, double v) {
    const double r = 0.5 + 0.08 * std::cos(2 * kPi * v), angle = 0.5 * kPi * u;
    return Vec3(r * std::cos(angle), 0.08 * std::sin(2 * kPi * v), r * std::sin(angle));
  });
}

Surface torus() {
  return ring_grid(61, 20, [](double u, double v) {
    const double r = 0.5 + 0.1 * std::cos(2 * kPi * v), angle = 2 * kPi * u;
    return Vec3(r * std::cos(angle), r * std::sin(angle), 0.1 * std::sin(2 * kPi * v));
  });
}

Surface sphere() {
  return ring_grid(24, 32, [](double u, double v) {
    const double polar = kPi * (0.001 + 0.998 * u);
    const double r = 0.4 * std::sin(polar);
    return Vec3(r * std::cos(2 * kPi * v), r * std::sin(2 * kPi * v), 0.4 * std::cos(polar));
  });
}

Surface two_legs() {
  Surface s = tube(0.06, 0.1, 0.8), other = s;
  other.map([](const Vec3& x) { return Vec3(x.x() + 0.3, x.y(), x.z()); });
  s.add(other);
  return s;
}

Surface mannequin() {
  Surface s;
  static const TriangleMesh mesh = make_mannequin({.faces = 5000});
  s.x_t0 = mesh.vertices;
  s.triangles = mesh.triangles;
  s.close();
  return s;
}

Surface soup(unsigned seed, int vertices, int triangles) {
  Random random(seed);
  Surface s;
  for (int i = 0; i < vertices; ++i) s.x_t0.push_back(random.vector(0.5));
  const auto any = [&] { return random.below(vertices); };
  for (int i = 0; i < triangles; ++i) s.triangles.push_back({any(), any(), any()});
  s.close();
  s.edges.push_back({any(), any()});
  for (Vec3& x : s.x_t1) x += random.vector(std::pow(10.0, random.below(5) - 4));
  return s;
}

/// All bodies, by name, those without extent in some direction too.
std::vector<std::pair<std::string, Surface>> bodies() {
  std::vector<std::pair<std::string, Surface>> all = {
      {"tube", tube(0.1, 0.1, 1.0)}, {"cone", tube(0.02, 0.2, 1.0)},
      {"bent tube", bent_tube()},    {"torus", torus()},
      {"sphere", sphere()},          {"two legs", two_legs()},
      {"mannequin", mannequin()},    {"soup", soup(1, 300, 500)}};
  Surface flat = tube(0.1, 0.1, 1.0, 20, 10), point = flat, line = flat, one, points;
  flat.map([](const Vec3& x) { return Vec3(x.x(), 0.25, x.z()); });
  point.map([](const Vec3&) { return Vec3(0.1, 0.2, 0.3); });
  line.map([](const Vec3& x) { return Vec3(0, 0, x.z()); });
  one.x_t0 = {{0, 0, 0}, {1, 0, 0.1}, {0, 0.5, 0}};
  one.triangles = {{0, 1, 2}};
  one.close();
  points.x_t0 = points.x_t1 = {{0, 0, 0}, {0.1, 0.4, 0.3}, {-0.3, 0.1, 0.2}};
  all.insert(all.end(),
             {{"flat", flat}, {"point", point}, {"line", line}, {"one", one}, {"points", points}});
  return all;
}

/// The body turned, shifted and moved by a step that bends it.
Surface moving(Surface s, const Vec3& shift) {
  const Eigen::AngleAxisd turn(0.7, Vec3(0.3, 0.8, -0.5).normalized());
  s.map([&](const Vec3& x) { return Vec3(turn * x + shift); });
  for (Vec3& x : s.x_t1) x += Vec3(0.03, -0.02, 0.01 * std::sin(9.0 * (x.x() - shift.x())));
  return s;
}

/// A sheet of n x n squares around the box of a body, crumpled a little and falling.
Surface cloth_over(const Surface& body, int n, unsigned seed, double away = 0.0) {
  Random random(seed);
  Vec3 lo = body.x_t0[0], hi = lo;
  for (const Vec3& x : body.x_t0) {
    lo = lo.cwiseMin(x);
    hi = hi.cwiseMax(x);
  }
  const double size = std::max((hi - lo).maxCoeff(), 0.1);
  const Vec3 middle = 0.5 * (lo + hi) + Vec3(away, 0, 0);
  const Eigen::AngleAxisd turn(random.uniform(0, 3), random.vector(1.0).normalized());
  Surface s;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      s.x_t0.push_back(middle +
                       turn * Vec3(1.3 * size * (static_cast<double>(i) / n - 0.5),
                                   1.3 * size * (static_cast<double>(j) / n - 0.5), 0) +
                       random.vector(0.2 * size / n));
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, c = a + n + 1;
      s.triangles.push_back({a, a + 1, c + 1});
      s.triangles.push_back({a, c + 1, c});
    }
  s.close();
  for (Vec3& x : s.x_t1) x += random.vector(0.05 * size) - Vec3(0, 0, 0.02 * size);
  return s;
}

CandidatePairs truth_of(const Surface& a, const Surface& b) {
  return pairs_of(*make_brute_force(), a, b);
}

/// How many of points of the body, anywhere during the step and within its thickness, are outside.
std::size_t outside_count(const Enclosure& enclosure, const Surface& s, unsigned seed) {
  Random random(seed);
  std::size_t outside = 0;
  const auto look = [&](const Vec3& at_t0, const Vec3& at_t1) {
    const double t = random.uniform(0, 1);
    const Vec3 x = at_t0 + t * (at_t1 - at_t0) + random.vector(s.thickness);
    outside += !enclosure.contains(x);
  };
  for (std::size_t v = 0; v < s.x_t0.size(); ++v) {
    outside += !enclosure.contains(s.x_t0[v]) + !enclosure.contains(s.x_t1[v]);
    look(s.x_t0[v], s.x_t1[v]);
  }
  for (const Triangle& t : s.triangles) {
    const double u = random.uniform(0, 1), v = random.uniform(0, 1 - u), w = 1 - u - v;
    look(w * s.x_t0[t[0]] + u * s.x_t0[t[1]] + v * s.x_t0[t[2]],
         w * s.x_t1[t[0]] + u * s.x_t1[t[1]] + v * s.x_t1[t[2]]);
  }
  return outside;
}

}  // namespace

TEST(Enclosure, HoldsAllOfABodyOverTheStep) {
  for (const auto& [name, body] : bodies())
    for (const int loops : {1, 2, 7, 32}) {
      for (const double far : {0.0, 1e6}) {
        const Surface s = moving(body, Vec3(far, 1, -far));
        const Enclosure enclosure = make_enclosure(s.view(), {.loops = loops});
        EXPECT_EQ(outside_count(enclosure, s, 5), 0u) << name << ", " << loops << " loops";
      }
    }
}

TEST(Enclosure, HasTwiceTheLoopsLessOnePrimitives) {
  for (const auto& [name, body] : bodies())
    for (const int loops : {1, 2, 5, 24}) {
      const Enclosure enclosure = make_enclosure(body.view(), {.loops = loops});
      EXPECT_EQ(enclosure.columns.size(), static_cast<std::size_t>(loops)) << name;
      EXPECT_EQ(enclosure.cones.size() + 1, enclosure.columns.size()) << name;
    }
}

TEST(Enclosure, IsCutAcrossTheLongestExtent) {
  Surface leg = tube(0.1, 0.1, 1.0);
  leg.map([](const Vec3& x) { return Vec3(x.y(), x.z(), x.x()); });
  for (const Column& column : make_enclosure(leg.view(), {.loops = 3}).columns)
    EXPECT_GT(std::abs(column.axis.y()), 0.999999);
}

TEST(Enclosure, OfASingleVertexContainsIt) {
  Surface one;
  one.x_t0 = one.x_t1 = {{0.1, 0.2, 0.3}};
  EXPECT_TRUE(make_enclosure(one.view()).contains(one.x_t0[0]));
}

TEST(Enclosure, IsTightAroundTubesAndCones) {
  const double r = 0.1;
  const Surface straight = tube(r, r, 1.0, 160, 96);
  EXPECT_LT(make_enclosure(straight.view()).volume(), 1.3 * kPi * r * r);
  // Cones follow a cone, where one column is three times as large.
  const Surface cone = tube(0.02, 0.2, 1.0, 160, 96);
  const double volume = kPi / 3 * (0.02 * 0.02 + 0.02 * 0.2 + 0.2 * 0.2);
  double last = std::numeric_limits<double>::infinity();
  for (const int loops : {1, 2, 4, 8}) {
    const double now = make_enclosure(cone.view(), {.loops = loops}).volume();
    EXPECT_LT(now, last) << loops;
    EXPECT_GT(now, volume);
    last = now;
  }
  EXPECT_LT(last, 1.3 * volume);
}

TEST(Enclosure, PrimitivesContainWhatLiesBetweenTheirDiscsAndWall) {
  Random random(3);
  for (int round = 0; round < 200; ++round) {
    const Vec3 axis = random.vector(1.0).normalized(), side = axis.unitOrthogonal();
    const Vec3 base = random.vector(1.0);
    const TruncatedCone cone{base, base + 0.7 * axis + random.uniform(-0.5, 0.5) * side, axis,
                             random.uniform(0, 0.4), random.uniform(0, 0.4)};
    const Column column{base, axis, 0.7, 0.3};
    EXPECT_NEAR(column.volume(), kPi * 0.063, 1e-12);
    for (int i = 0; i < 40; ++i) {
      // A disc at t, a direction in it.
      const double t = random.uniform(0.001, 0.999), turn = random.uniform(0, 2 * kPi);
      const Vec3 out = std::cos(turn) * side + std::sin(turn) * axis.cross(side);
      const double r = (1 - t) * cone.base_radius + t * cone.top_radius;
      const Vec3 middle = (1 - t) * cone.base + t * cone.top;
      EXPECT_TRUE(cone.contains(middle + 0.999 * r * out));
      EXPECT_FALSE(cone.contains(middle + 1.001 * r * out));
      EXPECT_FALSE(cone.contains(cone.base - t * axis));
      EXPECT_FALSE(cone.contains(cone.top + t * axis));
      EXPECT_TRUE(column.contains(base + 0.7 * t * axis + 0.2999 * out));
      EXPECT_FALSE(column.contains(base + 0.7 * t * axis + 0.3001 * out));
      EXPECT_FALSE(column.contains(base + (0.7 + t) * axis));
    }
  }
  const TruncatedCone upright{{0, 0, 0}, {0, 0, 3}, {0, 0, 1}, 2.0, 1.0};
  EXPECT_NEAR(upright.volume(), kPi * 7.0, 1e-12);
}

TEST(MinimalEnclosure, FindsThePairsOfBruteForceAroundEveryBody) {
  std::size_t pairs = 0, dropped = 0;
  for (const auto& [name, body] : bodies())
    for (const int loops : {1, 3, 24}) {
      auto detector = make_minimal_enclosure({.loops = loops});
      for (unsigned seed = 0; seed < 3; ++seed) {
        const Surface s = moving(body, Vec3(seed == 2 ? 1e6 : 0.0, 0, 0));
        const Surface cloth = cloth_over(s, 12, seed, seed == 1 ? 0.3 : 0.0);
        const CandidatePairs truth = truth_of(cloth, s);
        ASSERT_TRUE(same(pairs_of(*detector, cloth, s), truth)) << name << " " << loops;
        pairs += truth.size();
        dropped += detector->last_counts().dropped;
      }
    }
  EXPECT_GT(pairs, 10'000u);
  EXPECT_GT(dropped, 10'000u);
}

TEST(MinimalEnclosure, IsRightOnGeneratedScenes) {
  for (const int loops : {1, 24}) {
    const ConformanceReport report =
        check_conformance([&] { return make_minimal_enclosure({.loops = loops}); },
                          {.first_seed = 5000, .scenes = 150, .touching = {}});
    EXPECT_TRUE(report.passed()) << report.summary();
    EXPECT_GT(report.pairs, 10'000u);
  }
}

TEST(MinimalEnclosure, DropsNothingThatCollides) {
  const auto exact = narrow_phases().at("ccd_exact")({});
  std::size_t hits = 0;
  for (const auto& [name, body] : bodies()) {
    const Surface s = moving(body, Vec3::Zero());
    const Surface cloth = cloth_over(s, 10, 7);
    CandidatePairs everything;  // Also pairs whose boxes do not meet: no broad phase is believed.
    for (std::size_t v = 0; v < cloth.x_t0.size(); v += 3)
      for (std::size_t t = 0; t < s.triangles.size(); t += 7)
        everything.point_triangle.push_back(
            {static_cast<std::int32_t>(v), static_cast<std::int32_t>(t)});
    const CandidatePairs found = pairs_of(*make_minimal_enclosure(), cloth, s);
    for (const PointTrianglePair& pair : everything.point_triangle) {
      const Triangle& t = s.triangles[pair.triangle];
      const Query query{ContactKind::point_triangle,
                        {cloth.x_t0[pair.point], s.x_t0[t[0]], s.x_t0[t[1]], s.x_t0[t[2]]},
                        {cloth.x_t1[pair.point], s.x_t1[t[0]], s.x_t1[t[1]], s.x_t1[t[2]]}};
      double toi = 0.0;
      if (!exact->collides(query, toi)) continue;
      ++hits;
      EXPECT_TRUE(
          std::binary_search(found.point_triangle.begin(), found.point_triangle.end(), pair))
          << name;
    }
  }
  EXPECT_GT(hits, 20u);
}

TEST(MinimalEnclosure, FollowsABodyThatMoves) {
  auto detector = make_minimal_enclosure();
  Surface body = mannequin();
  std::size_t pairs = 0;
  for (int step = 0; step < 6; ++step) {
    // It walks, turns and bends.
    const Eigen::AngleAxisd turn(0.05, Vec3(0.1 * step, 1, 0.2).normalized());
    body.x_t0 = body.x_t1;
    for (Vec3& x : body.x_t1) {
      x = turn * x + Vec3(0.02, 0, 0.01);
      x.z() += 0.01 * std::sin(3.0 * x.x());
    }
    const Surface cloth = cloth_over(body, 16, step);
    const CandidatePairs truth = truth_of(cloth, body);
    ASSERT_TRUE(same(pairs_of(*detector, cloth, body), truth)) << step;
    EXPECT_EQ(outside_count(detector->last_enclosure(), body, step), 0u) << step;
    pairs += truth.size();
  }
  EXPECT_GT(pairs, 1000u);
}

TEST(MinimalEnclosure, FollowsABodyThatChangesItsShapeOrItsTriangles) {
  auto detector = make_minimal_enclosure();
  Surface body = tube(0.1, 0.1, 1.0);
  const Surface cloth = cloth_over(body, 12, 1);
  EXPECT_TRUE(same(pairs_of(*detector, cloth, body), truth_of(cloth, body)));
  Random random(2);
  body.map([&](const Vec3& x) { return Vec3(x.y(), x.x() + random.uniform(-0.3, 0.3), x.z()); });
  EXPECT_TRUE(same(pairs_of(*detector, cloth, body), truth_of(cloth, body)));
  // Other triangles on as many vertices.
  for (Triangle& t : body.triangles) t[2] = (t[2] + 471) % 960;
  body.edges = tube(0.1, 0.1, 1.0).edges;
  EXPECT_TRUE(same(pairs_of(*detector, cloth, body), truth_of(cloth, body)));
}

TEST(MinimalEnclosure, DoesNotLookAgainAtAStaticBody) {
  auto detector = make_minimal_enclosure();
  Surface body = two_legs();
  body.static_id = 11;
  const Surface cloth = cloth_over(body, 14, 3);
  const CandidatePairs truth = truth_of(cloth, body);
  EXPECT_TRUE(same(pairs_of(*detector, cloth, body), truth));
  // Whoever looked would refuse this.
  Surface unseen = body;
  for (auto* xs : {&unseen.x_t0, &unseen.x_t1}) xs->front().x() = std::nan("");
  EXPECT_TRUE(same(pairs_of(*detector, cloth, unseen), truth));
  unseen.static_id = 0;
  EXPECT_THROW(pairs_of(*detector, cloth, unseen), std::invalid_argument);
  // Other boxes: the promise is of positions only.
  body.thickness = 0.05;
  EXPECT_TRUE(same(pairs_of(*detector, cloth, body), truth_of(cloth, body)));
}

TEST(MinimalEnclosure, TellsStaticBodiesApart) {
  auto detector = make_minimal_enclosure();
  Surface body = two_legs(), other = torus();
  const Surface cloth = cloth_over(body, 14, 3);
  for (const int id : {21, 22}) {
    body.static_id = id;
    other.static_id = id + 10;
    EXPECT_TRUE(same(pairs_of(*detector, cloth, body), truth_of(cloth, body))) << id;
    EXPECT_TRUE(same(pairs_of(*detector, cloth, other), truth_of(cloth, other))) << id;
  }
}

TEST(MinimalEnclosure, DropsAtOnceWhatIsFar) {
  const Surface body = mannequin();
  const Surface far = cloth_over(body, 20, 1, 10.0), near = cloth_over(body, 20, 1);
  auto detector = make_minimal_enclosure();
  EXPECT_EQ(pairs_of(*detector, far, body).size(), 0u);
  EXPECT_EQ(detector->last_counts().dropped, detector->last_counts().asked);
  EXPECT_EQ(detector->last_counts().enclosure_tests, 0u);
  EXPECT_EQ(detector->last_counts().box_tests, 0u);
  pairs_of(*detector, near, body);
  const MinimalEnclosureCounts counts = detector->last_counts();
  EXPECT_EQ(counts.asked, near.x_t0.size() + near.edges.size() + near.triangles.size());
  EXPECT_GT(counts.dropped, counts.asked / 2);
  EXPECT_LE(counts.enclosure_tests, counts.primitives * counts.asked);
  EXPECT_LT(counts.box_tests, counts.asked * body.triangles.size() / 20);
}

TEST(MinimalEnclosure, FindsTheSameForAnyNumberOfThreads) {
  const Surface body = moving(mannequin(), Vec3::Zero()), cloth = cloth_over(body, 60, 4);
  const CandidatePairs truth = truth_of(cloth, body);
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    EXPECT_TRUE(same(pairs_of(*make_minimal_enclosure(), cloth, body), truth)) << threads;
  }
}

TEST(MinimalEnclosure, KeepsItsBudgetAndGoesOn) {
  const Surface body = two_legs(), cloth = cloth_over(body, 30, 2);
  const CandidatePairs truth = truth_of(cloth, body);
  ASSERT_GT(truth.size(), 10u);
  auto detector = make_minimal_enclosure();
  CandidatePairs out;
  detector->set_budget({.pairs = truth.size() - 1});
  EXPECT_THROW(detector->find_pairs(cloth.view(), body.view(), out), BudgetExceeded);
  EXPECT_EQ(out.size(), 0u);
  detector->set_budget({.pairs = truth.size()});
  EXPECT_TRUE(same(pairs_of(*detector, cloth, body), truth));
}

TEST(MinimalEnclosure, RefusesWhatItCannotServe) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const int loops : {0, -3, 4097})
    EXPECT_THROW(make_minimal_enclosure({.loops = loops}), std::invalid_argument);
  auto detector = make_minimal_enclosure();
  EXPECT_FALSE(detector->traits().self);
  CandidatePairs out;
  Surface body = tube(0.1, 0.1, 1.0);
  EXPECT_THROW(detector->find_self_pairs(body.view(), out), std::invalid_argument);
  body.x_t1[3].y() = infinity;
  EXPECT_THROW(make_enclosure(body.view()), std::invalid_argument);
  body.x_t1[3].y() = 1e300;
  EXPECT_THROW(make_enclosure(body.view()), std::invalid_argument);
  const Surface cloth = cloth_over(tube(0.1, 0.1, 1.0), 5, 1);
  EXPECT_TRUE(same(pairs_of(*detector, cloth, body), truth_of(cloth, body)));
  EXPECT_TRUE(make_enclosure(Surface().view()).columns.empty());
}

}  // namespace selvedge::minimal_enclosure_test
