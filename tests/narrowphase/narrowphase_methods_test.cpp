// SPDX-License-Identifier: MIT
// The published methods beside ccd_exact: known answers, what their tolerances do, how far they
// agree with ccd_exact, and that nothing makes them return anything but a time or no collision.
#include <gtest/gtest.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/cubic.h>
#include <selvedge/narrowphase/distance.h>
#include <selvedge/narrowphase/internal/particle_body.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <map>
#include <random>
#include <stdexcept>
#include <string>

#include "hard_queries.h"

namespace selvedge::narrowphase_methods_test {
namespace {

using namespace hard_queries;
using Method = std::unique_ptr<NarrowPhase>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

Vec3 vector(Random& r, double size) {
  return {real(r, -size, size), real(r, -size, size), real(r, -size, size)};
}

double exact_time(const Query& q) {
  static const Method method = make_ccd_exact();
  return time_of(*method, q);
}

constexpr std::array kNames = {"ccd_cubic",      "ccd_cubic_provot",  "ccd_cubic_bridson",
                               "plane_crossing", "centroid_velocity", "proximity"};

Method make(const std::string& name, const MethodOptions& options = {}) {
  return narrow_phases().at(name)(options);
}

bool answers(const std::string& name, ContactKind kind) {
  if (name == "plane_crossing") return kind == ContactKind::point_triangle;
  if (name == "centroid_velocity") return kind == ContactKind::edge_edge;
  return true;
}

/// A point over a triangle at rest falls from `height` by 1; or an edge over another.
Query falling(ContactKind kind, double height, const Vec3& aside = Vec3::Zero()) {
  Query q;
  q.kind = kind;
  if (kind == ContactKind::edge_edge) {
    q.x_t0 = {Vec3(-1, 0, height) + aside, Vec3(1, 0, height) + aside, Vec3(0, -1, 0),
              Vec3(0, 1, 0)};
  } else {
    q.x_t0 = {Vec3(0.25, 0.25, height) + aside, Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  }
  q.x_t1 = q.x_t0;
  const int moved = kind == ContactKind::edge_edge ? 2 : 1;
  for (int k = 0; k < moved; ++k) q.x_t1[k].z() -= 1.0;
  return q;
}

constexpr std::array kKinds = {ContactKind::point_triangle, ContactKind::edge_edge};

// ---------------------------------------------------------------------------------------------
// Known answers

TEST(Methods, FindTheTimeOfAFall) {
  for (const std::string name : kNames) {
    if (name == "proximity") continue;
    for (const ContactKind kind : kKinds) {
      const double expected = answers(name, kind) ? 0.25 : kNoCollision;
      EXPECT_EQ(time_of(*make(name), falling(kind, 0.25)), expected) << name;
      EXPECT_EQ(time_of(*make(name), falling(kind, 1.25)), kNoCollision) << name;
      EXPECT_EQ(time_of(*make(name), falling(kind, 0.25, Vec3(3, 3, 0))), kNoCollision) << name;
    }
  }
}

TEST(Methods, CountTouchingAtTheFirstAndTheLastInstant) {
  for (const std::string name : kNames) {
    if (name == "proximity") continue;
    for (const ContactKind kind : kKinds) {
      if (!answers(name, kind)) continue;
      EXPECT_EQ(time_of(*make(name), falling(kind, 0.0)), 0.0) << name;
      EXPECT_EQ(time_of(*make(name), falling(kind, 1.0)), 1.0) << name;
    }
  }
}

TEST(Methods, SayWhoseTheyAreAndWhereTheyFail) {
  for (const std::string name : kNames) {
    const NarrowPhaseTraits traits = make(name)->traits();
    EXPECT_FALSE(traits.misses_nothing) << name;
    EXPECT_FALSE(traits.no_false_alarm) << name;
    EXPECT_EQ(traits.gives_time, name != "proximity") << name;
    EXPECT_NE(traits.source.find(", "), std::string::npos) << name;
    EXPECT_FALSE(traits.limits.empty()) << name;
  }
}

TEST(Methods, RefuseWhatTheyCannotDo) {
  for (const std::string name : kNames) {
    if (name != "ccd_cubic") {
      EXPECT_THROW(make(name, {{"tolerance", kNan}}), std::invalid_argument) << name;
    }
    EXPECT_THROW(make(name, {{"min_separation", kNan}}), std::invalid_argument) << name;
    EXPECT_THROW(make(name, {{"min_separation", -1.0}}), std::invalid_argument) << name;
    Query q = falling(ContactKind::edge_edge, 0.5);
    q.x_t1[2].y() = kNan;
    EXPECT_THROW(time_of(*make(name), q), std::invalid_argument) << name;
    if (name != "proximity") {
      EXPECT_THROW(make(name, {{"min_separation", 0.1}}), std::invalid_argument) << name;
    }
  }
}

// ---------------------------------------------------------------------------------------------
// Tolerances

TEST(Methods, ProvotsToleranceWidensTheInsideTest) {
  // The point passes 1e-4 outside the edge x = 0 of a triangle of size 1; edges: 1e-4 of 2.
  for (const ContactKind kind : kKinds) {
    const double aside = kind == ContactKind::edge_edge ? 1.0 + 1e-4 : -0.25 - 1e-4;
    const Query q = falling(kind, 0.5, Vec3(aside, 0, 0));
    EXPECT_EQ(time_of(*make("ccd_cubic"), q), kNoCollision);
    EXPECT_EQ(time_of(*make("ccd_cubic_provot"), q), kNoCollision);
    EXPECT_EQ(time_of(*make("ccd_cubic_provot", {{"tolerance", 1e-3}}), q), 0.5);
    EXPECT_EQ(time_of(*make("ccd_cubic_provot", {{"tolerance", 2e-5}}), q), kNoCollision);
  }
}

TEST(Methods, BridsonsToleranceIsADistance) {
  for (const ContactKind kind : kKinds) {
    const double aside = kind == ContactKind::edge_edge ? 1.0 + 1e-4 : -0.25 - 1e-4;
    const Query beside = falling(kind, 0.5, Vec3(aside, 0, 0));
    EXPECT_EQ(time_of(*make("ccd_cubic_bridson"), beside), kNoCollision);
    EXPECT_EQ(time_of(*make("ccd_cubic_bridson", {{"tolerance", 1.1e-4}}), beside), 0.5);
    EXPECT_EQ(time_of(*make("ccd_cubic_bridson", {{"tolerance", 0.9e-4}}), beside), kNoCollision);
    // It stops short of the plane by 1e-3: seen at the end of the step.
    const Query above = falling(kind, 1.0 + 1e-3);
    EXPECT_EQ(time_of(*make("ccd_cubic_bridson"), above), kNoCollision);
    EXPECT_EQ(time_of(*make("ccd_cubic_bridson", {{"tolerance", 2e-3}}), above), 1.0);
  }
}

TEST(Methods, ProximityLooksAtBothEndsAndNotBetween) {
  for (const ContactKind kind : kKinds) {
    EXPECT_EQ(time_of(*make("proximity"), falling(kind, 0.5)), kNoCollision);  // passes through
    EXPECT_EQ(time_of(*make("proximity"), falling(kind, 0.5e-3)), 0.0);
    const Query near_end = falling(kind, 1.0 + 0.5e-3);
    EXPECT_NEAR(time_of(*make("proximity"), near_end), 1.0 - 0.5e-3, 1e-12);
    EXPECT_EQ(time_of(*make("proximity", {{"tolerance", 1e-4}}), near_end), kNoCollision);
    EXPECT_NEAR(time_of(*make("proximity", {{"min_separation", 0.1}}), near_end), 0.9005, 1e-12);
  }
}

TEST(Methods, TheReachOfTheCentroidsMotionIsADistance) {
  const Query q = falling(ContactKind::edge_edge, 0.5);
  EXPECT_EQ(time_of(*make("centroid_velocity", {{"tolerance", 0.4}}), q), kNoCollision);
  EXPECT_EQ(time_of(*make("centroid_velocity", {{"tolerance", 0.6}}), q), 0.5);
  const Query later = falling(ContactKind::edge_edge, 1.5);
  EXPECT_EQ(time_of(*make("centroid_velocity", {{"tolerance", 2.0}}), later), 1.0);
}

TEST(Methods, ThePlanesToleranceWidensTheTriangle) {
  const Query q = falling(ContactKind::point_triangle, 0.5, Vec3(-0.25 - 1e-4, 0, 0));
  EXPECT_EQ(time_of(*make("plane_crossing"), q), kNoCollision);
  EXPECT_EQ(time_of(*make("plane_crossing", {{"tolerance", 1e-3}}), q), 0.5);
}

/// No point of the primitives may be nearer than the tolerance before proximity's time.
TEST(Methods, TheTimeOfAProximityIsNeverLate) {
  Random r(11);
  const double reach = 0.2;
  const Method method = make("proximity", {{"tolerance", reach}});
  int later_than_0 = 0;
  for (int i = 0; i < 4000; ++i) {
    Query q;
    q.kind = kKinds[i % 2];
    for (auto* x : {&q.x_t0, &q.x_t1})
      for (Vec3& v : *x) v = vector(r, 1.0);
    const double toi = time_of(*method, q);
    if (toi == kNoCollision || toi == 0.0) continue;
    ++later_than_0;
    for (int k = 0; k < 50; ++k) {
      const double t = toi * k / 50.0;
      std::array<Vec3, 4> x;
      for (int v = 0; v < 4; ++v) x[v] = q.x_t0[v] + t * (q.x_t1[v] - q.x_t0[v]);
      const ClosestPoints near = q.kind == ContactKind::edge_edge
                                     ? edge_edge_closest(x[0], x[1], x[2], x[3])
                                     : point_triangle_closest(x[0], x[1], x[2], x[3]);
      ASSERT_GE(near.distance, reach * (1.0 - 1e-12)) << text(q);
    }
  }
  EXPECT_GT(later_than_0, 200);
}

// ---------------------------------------------------------------------------------------------
// Agreement with ccd_exact

Query uniform(Random& r, ContactKind kind) {
  Query q;
  q.kind = kind;
  for (auto* x : {&q.x_t0, &q.x_t1})
    for (Vec3& v : *x) v = vector(r, 1.0);
  return q;
}

/// Each primitive moves as one.
Query translating(Random& r, ContactKind kind) {
  Query q = uniform(r, kind);
  const Vec3 first = vector(r, 1.0), second = vector(r, 1.0);
  const int moved = kind == ContactKind::edge_edge ? 2 : 1;
  for (int k = 0; k < 4; ++k) q.x_t1[k] = q.x_t0[k] + (k < moved ? first : second);
  return q;
}

/// A few small integers: touchings, degenerate primitives and motions in a plane abound.
Query grid(Random& r, ContactKind kind) {
  Query q;
  q.kind = kind;
  const int size = integer(r, 1, 3);
  for (auto* x : {&q.x_t0, &q.x_t1})
    for (Vec3& v : *x)
      for (int i = 0; i < 3; ++i) v[i] = integer(r, -size, size);
  return q;
}

struct Agreement {
  int queries = 0, hits = 0, misses = 0, false_alarms = 0, late = 0;
};

template <class Generator>
Agreement agreement(const NarrowPhase& method, ContactKind kind, int n, Generator generate) {
  Random r(2026);
  Agreement a;
  for (int i = 0; i < n; ++i) {
    const Query q = generate(r, kind);
    const double truth = exact_time(q), toi = time_of(method, q);
    ++a.queries;
    a.hits += truth != kNoCollision;
    a.misses += truth != kNoCollision && toi == kNoCollision;
    a.false_alarms += truth == kNoCollision && toi != kNoCollision;
    a.late += truth != kNoCollision && toi != kNoCollision && toi > truth + 1e-9;
  }
  return a;
}

template <class Generator>
Agreement report(const std::string& name, ContactKind kind, int n, const char* what,
                 Generator generate) {
  const Agreement a = agreement(*make(name), kind, n, generate);
  std::cout << name << (kind == ContactKind::edge_edge ? " edge_edge " : " point_triangle ") << what
            << ": " << a.queries << " queries, " << a.hits << " hits, " << a.misses << " misses, "
            << a.false_alarms << " false alarms, " << a.late << " late\n";
  EXPECT_GT(a.hits, n / 100);
  return a;
}

TEST(Methods, TheCubicsAgreeWithTheExactMethodOnRandomQueries) {
  for (const std::string name : {"ccd_cubic", "ccd_cubic_provot", "ccd_cubic_bridson"}) {
    for (const ContactKind kind : kKinds) {
      const Agreement a = report(name, kind, 20000, "random", uniform);
      EXPECT_EQ(a.misses, 0) << name;
      EXPECT_EQ(a.false_alarms, 0) << name;
      EXPECT_EQ(a.late, 0) << name;
    }
  }
}

TEST(Methods, TheCubicsToleranceSavesTouchingsButNotAllOfThem) {
  for (const ContactKind kind : kKinds) {
    const Agreement plain = report("ccd_cubic", kind, 10000, "grid", grid);
    const Agreement provot = report("ccd_cubic_provot", kind, 10000, "grid", grid);
    const Agreement bridson = report("ccd_cubic_bridson", kind, 10000, "grid", grid);
    EXPECT_LE(provot.misses, plain.misses);
    EXPECT_LT(bridson.misses, provot.misses);
    EXPECT_LE(plain.misses, plain.hits / 10);
    EXPECT_LE(provot.misses, plain.hits / 20);
    EXPECT_LE(bridson.misses, plain.hits / 200);
    // Where rounding leaves a primitive an area (or an angle) that it has not at the root.
    EXPECT_LE(plain.false_alarms, 2);
    EXPECT_LE(bridson.false_alarms, 2);
  }
}

TEST(Methods, ThePlaneIsRightAboutTrianglesThatDoNotTurn) {
  const auto kind = ContactKind::point_triangle;
  const Agreement a = report("plane_crossing", kind, 20000, "translating", translating);
  EXPECT_EQ(a.misses + a.false_alarms + a.late, 0);
  const Agreement b = report("plane_crossing", kind, 20000, "random", uniform);
  EXPECT_GT(b.misses + b.false_alarms, 0) << "it is approximate, is it not?";
  EXPECT_LT(b.misses, b.hits);
}

TEST(Methods, TheCentroidIsRightAboutEdgesThatDoNotTurn) {
  const auto kind = ContactKind::edge_edge;
  const Agreement a = report("centroid_velocity", kind, 20000, "translating", translating);
  EXPECT_EQ(a.misses + a.false_alarms + a.late, 0);
  const Agreement b = report("centroid_velocity", kind, 20000, "random", uniform);
  EXPECT_GT(b.misses + b.false_alarms, 0) << "it is approximate, is it not?";
  EXPECT_LT(b.misses, b.hits);
}

TEST(Methods, TheCentroidMissesAnEdgeThatTurnsAboutIt) {
  // The edge turns about its centre through the other, which it meets half way.
  Query q;
  q.kind = ContactKind::edge_edge;
  q.x_t0 = {Vec3(-1, 0, -1), Vec3(1, 0, 1), Vec3(0.5, -1, 0), Vec3(0.5, 1, 0)};
  q.x_t1 = {Vec3(-1, 0, 1), Vec3(1, 0, -1), Vec3(0.5, -1, 0), Vec3(0.5, 1, 0)};
  EXPECT_EQ(exact_time(q), 0.5);
  EXPECT_EQ(time_of(*make("ccd_cubic"), q), 0.5);
  EXPECT_EQ(time_of(*make("centroid_velocity"), q), kNoCollision);
}

TEST(Methods, ProximityMissesAndFeignsAsItSays) {
  for (const ContactKind kind : kKinds) {
    const Agreement a = report("proximity", kind, 20000, "random", uniform);
    EXPECT_GT(a.misses, 0);
    EXPECT_LT(a.false_alarms, a.queries / 100);
    EXPECT_EQ(a.late, 0);
  }
}

// ---------------------------------------------------------------------------------------------
// Invariance and bad input

TEST(Methods, ScalingByAPowerOfTwoNeverChangesTheTime) {
  for (const std::string name :
       {"ccd_cubic", "ccd_cubic_provot", "plane_crossing", "centroid_velocity"}) {
    const Method method = make(name);
    Random r(3);
    for (int i = 0; i < 4000; ++i) {
      Query q = i % 4 < 2 ? grid(r, kKinds[i % 2]) : uniform(r, kKinds[i % 2]);
      // Multiples of 2^-24: their differences are doubles, so that moving them rounds nothing.
      for (auto* x : {&q.x_t0, &q.x_t1})
        for (Vec3& v : *x)
          for (int k = 0; k < 3; ++k) v[k] = std::round(v[k] * 0x1p24) * 0x1p-24;
      const double toi = time_of(*method, q);
      const int exponent = integer(r, -900, 900);
      for (auto* x : {&q.x_t0, &q.x_t1})
        for (Vec3& v : *x) v *= std::ldexp(1.0, exponent);
      ASSERT_EQ(time_of(*method, q), toi) << name << " scaled by 2^" << exponent << text(q);
    }
  }
}

TEST(Methods, MovingTheObserverNeverChangesTheTime) {
  for (const std::string name : kNames) {
    const Method method = make(name);
    Random r(4);
    for (int i = 0; i < 2000; ++i) {
      Query q = grid(r, kKinds[i % 2]);
      const double toi = time_of(*method, q);
      const Vec3 at(1000, -77, 3), velocity(5, 12, -9);
      for (Vec3& v : q.x_t0) v += at;
      for (Vec3& v : q.x_t1) v += at + velocity;
      ASSERT_EQ(time_of(*method, q), toi) << name << text(q);
    }
  }
}

void degenerate(Random& r, Query& q) {
  switch (integer(r, 0, 4)) {
    case 0:
      q.x_t0[3] = q.x_t0[2], q.x_t1[3] = q.x_t1[2];
      break;
    case 1:
      q.x_t0[1] = q.x_t0[0], q.x_t1[1] = q.x_t1[0];
      break;
    case 2:
      for (int k = 1; k < 4; ++k) q.x_t0[k] = q.x_t0[0];
      break;
    case 3:
      for (auto* x : {&q.x_t0, &q.x_t1})
        for (Vec3& v : *x) v.z() = v.x() - v.y();
      break;
    default:
      q.x_t1 = q.x_t0;
  }
}

TEST(Methods, ReturnATimeOrNoCollisionWhateverTheInput) {
  const std::map<std::string, Method (*)(const NarrowPhaseConfig&)> factories{
      {"ccd_cubic", make_ccd_cubic},
      {"ccd_cubic_provot", make_ccd_cubic_provot},
      {"ccd_cubic_bridson", make_ccd_cubic_bridson},
      {"plane_crossing", make_plane_crossing},
      {"centroid_velocity", make_centroid_velocity},
      {"proximity", make_proximity}};
  for (const std::string name : kNames) {
    for (const double tolerance : {-1.0, 0.0, 1e-3, 1e300}) {
      const Method method = factories.at(name)({.tolerance = tolerance});
      Random r(5);
      for (int i = 0; i < 4000; ++i) {
        Query q = i % 3 == 0 ? grid(r, kKinds[i % 2]) : uniform(r, kKinds[i % 2]);
        if (i % 5 < 2) degenerate(r, q);
        const int most = i % 7 < 3 ? 1000 : 498;  // 2^498 is 1e150
        const double all = std::ldexp(1.0, integer(r, -most, most));
        for (auto* x : {&q.x_t0, &q.x_t1})
          for (Vec3& v : *x) v *= i % 2 == 0 ? all : std::ldexp(1.0, integer(r, -most, most));
        const double toi = time_of(*method, q);
        ASSERT_TRUE((toi >= 0.0 && toi <= 1.0) || toi == kNoCollision)
            << name << " returns " << toi << " for " << text(q);
      }
    }
  }
}

TEST(Methods, SeeContactAtSizesFromTinyToHuge) {
  for (const double size : {1e-150, 1e-100, 1e-20, 1.0, 1e20, 1e100, 1e150}) {
    for (const std::string name : kNames) {
      if (name == "proximity") continue;
      for (const ContactKind kind : kKinds) {
        if (!answers(name, kind)) continue;
        Query q = falling(kind, 0.5);
        for (auto* x : {&q.x_t0, &q.x_t1})
          for (Vec3& v : *x) v *= size;
        EXPECT_NEAR(time_of(*make(name), q), 0.5, 1e-9) << name << " at size " << size;
      }
    }
  }
}

// ---------------------------------------------------------------------------------------------
// The cubic in doubles

std::array<double, 4> cubic_with_roots(double a, double b, double c, double factor) {
  return {-factor * a * b * c, factor * (a * b + b * c + c * a), -factor * (a + b + c), factor};
}

TEST(EstimatedCubicRoots, AreTheRootsOfFactorsWhoseProductIsExact) {
  const CubicRootEstimates three = estimate_cubic_roots(cubic_with_roots(0.25, 0.5, 0.75, 4.0));
  ASSERT_EQ(three.count, 3);
  EXPECT_NEAR(three.t[0], 0.25, 1e-15);
  EXPECT_NEAR(three.t[1], 0.5, 1e-15);
  EXPECT_NEAR(three.t[2], 0.75, 1e-15);
  // A touching has to be asked for where rounding hides it; here it does not.
  const CubicRootEstimates twice = estimate_cubic_roots(cubic_with_roots(0.5, 0.5, 2.0, 1.0));
  ASSERT_EQ(twice.count, 1);
  EXPECT_EQ(twice.t[0], 0.5);
  const CubicRootEstimates ends = estimate_cubic_roots(cubic_with_roots(0.0, 1.0, 3.0, -1.0));
  ASSERT_EQ(ends.count, 2);
  EXPECT_EQ(ends.t[0], 0.0);
  EXPECT_EQ(ends.t[1], 1.0);
  const CubicRootEstimates triple = estimate_cubic_roots(cubic_with_roots(0.5, 0.5, 0.5, 1.0));
  ASSERT_EQ(triple.count, 1);
  EXPECT_NEAR(triple.t[0], 0.5, 1e-5);
}

TEST(EstimatedCubicRoots, OfLowerDegreeAndOfNone) {
  EXPECT_EQ(estimate_cubic_roots({1.0, 0.0, 0.0, 0.0}).count, 0);
  const CubicRootEstimates zero = estimate_cubic_roots({0.0, 0.0, 0.0, 0.0});
  ASSERT_EQ(zero.count, 2);
  EXPECT_EQ(zero.t[0], 0.0);
  EXPECT_EQ(zero.t[1], 1.0);
  const CubicRootEstimates line = estimate_cubic_roots({-1.0, 3.0, 0.0, 0.0});
  ASSERT_EQ(line.count, 1);
  EXPECT_NEAR(line.t[0], 1.0 / 3.0, 1e-15);
  const CubicRootEstimates parabola = estimate_cubic_roots({0.125, -0.75, 1.0, 0.0});
  ASSERT_EQ(parabola.count, 2);
  EXPECT_EQ(parabola.t[0], 0.25);
  EXPECT_EQ(parabola.t[1], 0.5);
}

TEST(EstimatedCubicRoots, TouchingCountsWithinTheGivenValue) {
  // (t - 1/2)^2 + 1e-12 has no root, but comes within 1e-12 of one.
  const std::array<double, 4> c{0.25 + 1e-12, -1.0, 1.0, 0.0};
  EXPECT_EQ(estimate_cubic_roots(c).count, 0);
  const CubicRootEstimates near = estimate_cubic_roots(c, 1e-11);
  ASSERT_EQ(near.count, 1);
  EXPECT_NEAR(near.t[0], 0.5, 1e-9);
}

TEST(EstimatedCubicRoots, RefuseWhatIsNotFinite) {
  EXPECT_THROW(estimate_cubic_roots({1.0, kNan, 0.0, 0.0}), std::invalid_argument);
  EXPECT_THROW(estimate_cubic_roots({1.0, 0.0, 0.0, kInf}), std::invalid_argument);
}

TEST(EstimatedCubicRoots, AgreeWithTheExactOnesOfAnySize) {
  Random r(8);
  int roots = 0;
  for (int i = 0; i < 20000; ++i) {
    const double size = std::ldexp(1.0, integer(r, -1000, 1000));
    std::array<double, 4> c;
    if (i % 2 == 0) {
      for (double& a : c) a = size * real(r, -1, 1);
    } else {
      c = cubic_with_roots(real(r, -0.5, 1.5), real(r, -0.5, 1.5), real(r, -0.5, 1.5), size);
    }
    const CubicRoots exact = cubic_roots(c);
    const CubicRootEstimates found = estimate_cubic_roots(c);
    ASSERT_EQ(static_cast<int>(exact.roots.size()), found.count) << "cubic " << i;
    for (int k = 0; k < found.count; ++k) {
      // A root moves by the rounding of the value over the slope.
      const double t = exact.roots[k].lo;
      const double slope = std::abs((3.0 * c[3] * t + 2.0 * c[2]) * t + c[1]) / size;
      ASSERT_NEAR(found.t[k], t, 1e-13 / std::min(1.0, slope)) << "cubic " << i;
    }
    roots += found.count;
  }
  EXPECT_GT(roots, 15000);
}

}  // namespace
}  // namespace selvedge::narrowphase_methods_test
