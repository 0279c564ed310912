// SPDX-License-Identifier: MIT
//
// Collisions along true rotations, against dense sampling of the motion in time by another formula.
#include <gtest/gtest.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/base/types.h>
#include <selvedge/detection/rotation.h>
#include <selvedge/narrowphase/distance.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "broad_phase_trial.h"

namespace selvedge::rotation_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kSamples = 800;

using Key = std::tuple<ContactKind, std::int32_t, std::int32_t>;

struct Rotor {
  std::vector<Vec3> x;
  std::vector<Triangle> triangles;
  RotatingMotion motion;

  RotatingSurface view() const { return {x, triangles, motion}; }

  /// By a unit quaternion, where the library uses Rodrigues' formula.
  std::vector<Vec3> at(double t) const {
    const double half = 0.5 * t * motion.turn.norm();
    const Vec3 axis = motion.turn.normalized();
    Eigen::Quaterniond q;
    q.w() = std::cos(half);
    q.vec() = std::sin(half) * axis;
    std::vector<Vec3> moved;
    for (const Vec3& p : x)
      moved.push_back(motion.pivot + t * motion.translation + q * (p - motion.pivot));
    return moved;
  }
  /// m, bound of the way of a vertex between two samples.
  double way() const {
    double r = 0.0;
    for (const Vec3& p : x) r = std::max(r, (p - motion.pivot).norm());
    return (r * motion.turn.norm() + motion.translation.norm()) / kSamples;
  }
};

/// Loose triangles within a ball of radius 1 around the pivot.
Rotor random_rotor(Random& random, const Vec3& pivot, double degrees) {
  Rotor rotor;
  rotor.motion = {pivot, degrees * kDegree * random.vector(1.0).normalized(), random.vector(0.3)};
  for (std::int32_t t = 0; t < 8; ++t) {
    const Vec3 centre = pivot + random.vector(0.5);
    for (int k = 0; k < 3; ++k) rotor.x.push_back(centre + random.vector(0.4));
    rotor.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return rotor;
}

/// Smallest sampled distance of a pair, and the first sample by which it has collided for certain.
struct Sampled {
  double nearest = std::numeric_limits<double>::infinity();  // m
  double collided = std::numeric_limits<double>::infinity();
};

double volume(const std::array<Vec3, 4>& x) {
  return (x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0]);
}

/// Samples one pair. It has collided if its orientation changes sign between two samples that both
/// have the closest points in the interior of the primitives and nearer than they can move.
Sampled sample(ContactKind kind, const std::vector<std::array<Vec3, 4>>& paths, double way) {
  Sampled s;
  double before = 0.0;
  bool inside_before = false;
  for (std::size_t k = 0; k < paths.size(); ++k) {
    const auto& x = paths[k];
    const ClosestPoints c = kind == ContactKind::edge_edge
                                ? edge_edge_closest(x[0], x[1], x[2], x[3])
                                : point_triangle_closest(x[0], x[1], x[2], x[3]);
    s.nearest = std::min(s.nearest, c.distance);
    bool inside = c.distance < way;
    for (const double w : c.weight) inside = inside && std::abs(w) > 0.05 && std::abs(w) <= 1.0;
    const double now = volume(x);
    if (inside && inside_before && now * before < 0.0)
      s.collided = std::min(s.collided, static_cast<double>(k) / kSamples);
    before = now;
    inside_before = inside;
  }
  return s;
}

std::map<Key, Sampled> sample_all(const Rotor& a, const Rotor& b) {
  std::vector<std::vector<Vec3>> xa, xb;
  for (int k = 0; k <= kSamples; ++k) {
    xa.push_back(a.at(static_cast<double>(k) / kSamples));
    xb.push_back(b.at(static_cast<double>(k) / kSamples));
  }
  std::map<Key, Sampled> all;
  const auto offer = [&](ContactKind kind, std::int32_t i, std::int32_t j, const auto& first,
                         const auto& f, const auto& second, const auto& s) {
    std::vector<std::array<Vec3, 4>> paths(first.size());
    for (std::size_t k = 0; k < paths.size(); ++k) {
      std::size_t n = 0;
      for (const std::int32_t v : f) paths[k][n++] = first[k][v];
      for (const std::int32_t v : s) paths[k][n++] = second[k][v];
    }
    all[{kind, i, j}] = sample(kind, paths, a.way() + b.way());
  };
  const auto points = [&](ContactKind kind, const auto& p, const auto& q,
                          const std::vector<Triangle>& triangles) {
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(p[0].size()); ++v)
      for (std::int32_t t = 0; t < static_cast<std::int32_t>(triangles.size()); ++t) {
        const bool swapped = kind == ContactKind::triangle_point;
        offer(kind, swapped ? t : v, swapped ? v : t, p, std::array{v}, q, triangles[t]);
      }
  };
  points(ContactKind::point_triangle, xa, xb, b.triangles);
  points(ContactKind::triangle_point, xb, xa, a.triangles);
  const auto edges_a = unique_edges(a.triangles), edges_b = unique_edges(b.triangles);
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(edges_a.size()); ++i)
    for (std::int32_t j = 0; j < static_cast<std::int32_t>(edges_b.size()); ++j)
      offer(ContactKind::edge_edge, i, j, xa, edges_a[i], xb, edges_b[j]);
  return all;
}

std::map<Key, double> times_of(const std::vector<Collision>& found) {
  std::map<Key, double> times;
  for (const Collision& c : found) times[{c.kind, c.primitive_a, c.primitive_b}] = c.toi;
  EXPECT_EQ(times.size(), found.size()) << "a pair is reported twice";
  return times;
}

std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "";
}

TEST(Rotation, DenseSamplingFindsNoMissAndNoPairBeyondTheTolerance) {
  constexpr double kTolerance = 0.01;
  std::size_t certain = 0, reported = 0;
  for (const double degrees : {20.0, 90.0, 350.0, 800.0})
    for (unsigned seed = 0; seed < 4; ++seed) {
      SCOPED_TRACE(std::to_string(degrees) + " degrees, seed " + std::to_string(seed));
      Random random(seed);
      const Rotor a = random_rotor(random, Vec3::Zero(), degrees);
      const Rotor b = random_rotor(random, Vec3(0.5, 0.2, 0.1), seed % 2 == 0 ? 0.0 : 70.0);
      const auto found =
          times_of(find_rotating_collisions(a.view(), b.view(), {.tolerance = kTolerance}));
      reported += found.size();
      for (const auto& [pair, s] : sample_all(a, b)) {
        const auto at = found.find(pair);
        if (s.collided <= 1.0) {
          ++certain;
          ASSERT_NE(at, found.end()) << "a collision by " << s.collided << " is missed";
          EXPECT_LE(at->second, s.collided);
        }
        if (at != found.end()) {
          EXPECT_LE(s.nearest, kTolerance + 0.5 * (a.way() + b.way()));
        }
      }
    }
  EXPECT_GT(certain, 700u);
  EXPECT_GT(reported, certain);
}

TEST(Rotation, ATouchingTipIsFoundWithinTheToleranceAndNotLate) {
  // The tip of a needle at radius 1 meets a wall beside its axis at 90 degrees of 180.
  for (const double wall : {0.999, 1.0 - 1e-9, 1.00001, 1.0002}) {
    Rotor needle;
    needle.x = {{1, 0, 0}, {0.5, 0, 0.01}, {0.5, 0, -0.01}};
    needle.triangles = {{0, 1, 2}};
    needle.motion.turn = {0, 0, 180.0 * kDegree};
    const std::vector<Vec3> x = {{-9, wall, -9}, {9, wall, -9}, {0, wall, 9}};
    const std::vector<Triangle> triangles = {{0, 1, 2}};
    const auto found = find_rotating_collisions(needle.view(), MovingSurface{x, x, triangles});
    if (wall > 1.0001) {
      EXPECT_TRUE(found.empty()) << wall;
      continue;
    }
    ASSERT_FALSE(found.empty()) << wall;
    EXPECT_EQ(found[0].kind, ContactKind::point_triangle);
    if (wall <= 1.0) {
      const double first = std::asin(wall) / std::numbers::pi;
      EXPECT_LE(found[0].toi, first);
      EXPECT_GT(found[0].toi, first - 0.01);
    }
    EXPECT_NEAR(found[0].normal.y(), -1.0, 0.02);
    // On the chord, the needle shrinks to its axis.
    EXPECT_TRUE(
        find_collisions({needle.x, needle.at(1.0), needle.triangles}, {x, x, triangles}).empty());
  }
}

TEST(Rotation, WithoutATurnTheTimeIsThatOfTheStraightPath) {
  Rotor tip;
  tip.x = {{0, 0, 0.5}, {0.1, 0, 0.6}, {-0.1, 0, 0.6}};
  tip.triangles = {{0, 1, 2}};
  tip.motion.translation = {0, 0, -1.0};
  const std::vector<Vec3> x = {{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}};
  const std::vector<Triangle> triangles = {{0, 1, 2}};
  const auto found = find_rotating_collisions(tip.view(), MovingSurface{x, x, triangles});
  ASSERT_FALSE(found.empty());
  EXPECT_LE(found[0].toi, 0.5);
  EXPECT_GT(found[0].toi, 0.5 - 1e-3);
}

TEST(Rotation, EveryDetectorAndAnyNumberOfThreadsGiveTheSame) {
  Random random(7);
  const Rotor a = random_rotor(random, Vec3::Zero(), 350.0);
  const Rotor b = random_rotor(random, Vec3(0.8, 0.0, 0.0), 90.0);
  const auto reference =
      times_of(find_rotating_collisions(a.view(), b.view(), {.broad_phase = "brute_force"}));
  EXPECT_FALSE(reference.empty());
  for (const char* name : {"bvh_aabb", "bvh_kdop18", "sweep_and_prune", "hash_grid"}) {
    EXPECT_EQ(times_of(find_rotating_collisions(a.view(), b.view(), {.broad_phase = name})),
              reference)
        << name;
  }
  const ThreadLimit one(1);
  EXPECT_EQ(times_of(find_rotating_collisions(a.view(), b.view())), reference);
}

TEST(Rotation, ChordsDeviateAtMostByTheBound) {
  for (const double degrees : {1.0, 30.0, 90.0, 180.0, 350.0}) {
    const RotatingMotion motion{.turn = {0, 0, degrees * kDegree}};
    const Vec3 x0(2, 0, 1), x1 = position_at(motion, x0, 1.0);
    double largest = 0.0;
    for (int k = 0; k <= 100; ++k) {
      const double t = k / 100.0;
      largest = std::max(largest, (position_at(motion, x0, t) - (1 - t) * x0 - t * x1).norm());
    }
    EXPECT_LE(largest, chord_deviation(2.0, degrees * kDegree));
    if (degrees < 45.0) {
      EXPECT_GT(largest, 0.95 * chord_deviation(2.0, degrees * kDegree));
    }
  }
}

TEST(Rotation, TheMotionBetweenTwoPosesStartsAndEndsThere) {
  Random random(3);
  for (int k = 0; k < 20; ++k) {
    const auto pose = [&] {
      const Vec3 axis = random.vector(1.0).normalized();
      return Pose{Eigen::AngleAxisd(random.uniform(0, 3), axis).toRotationMatrix(),
                  random.vector(2.0)};
    };
    const Pose from = pose(), to = pose();
    const Vec3 x = random.vector(1.0);
    const RotatingMotion motion = motion_between(from, to);
    EXPECT_LE(motion.turn.norm(), std::numbers::pi + 1e-12);
    const Vec3 start = from.rotation * x + from.translation;
    EXPECT_LT((position_at(motion, start, 0.0) - start).norm(), 1e-12);
    EXPECT_LT((position_at(motion, start, 1.0) - to.rotation * x - to.translation).norm(), 1e-12);
  }
}

TEST(Rotation, BadInputIsNamed) {
  Random random(1);
  const Rotor good = random_rotor(random, Vec3::Zero(), 30.0);
  const auto fault = [&](auto change, const RotationConfig& config = {}) {
    Rotor bad = good;
    change(bad);
    return message_of([&] { find_rotating_collisions(bad.view(), good.view(), config); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto none = [](Rotor&) {};
  EXPECT_NE(fault([&](Rotor& r) { r.motion.turn[1] = nan; }).find("a: the motion"),
            std::string::npos);
  EXPECT_NE(fault([&](Rotor& r) { r.x[2][0] = nan; }).find("a: x_t0[2]"), std::string::npos);
  EXPECT_NE(fault([&](Rotor& r) { r.triangles[1][0] = 99; }).find("a: triangles[1]"),
            std::string::npos);
  EXPECT_NE(fault(none, {.tolerance = 0.0}).find("tolerance is 0"), std::string::npos);
  EXPECT_NE(fault(none, {.tolerance = 1e-18}).find("tolerance"), std::string::npos);
  EXPECT_NE(fault(none, {.broad_phase = "nonsense"}).find("broad_phase"), std::string::npos);
}

}  // namespace
}  // namespace selvedge::rotation_test
