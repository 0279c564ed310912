// SPDX-License-Identifier: MIT
// Minimum separation against distances sampled in long double.
#include <gtest/gtest.h>
#include <selvedge/narrowphase/ccd_methods.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "hard_queries.h"

namespace selvedge::min_separation_test {
namespace {

using namespace hard_queries;

/// The L of make_ccd_separation.
double size_of(const Query& q) {
  double size = 0.0;
  for (const auto* x : {&q.x_t0, &q.x_t1})
    for (const Vec3& v : *x) size = std::max(size, (v - (*x)[0]).cwiseAbs().maxCoeff());
  return size;
}

/// Error of distance_at, as a part of L: conditioning of near-parallel interiors.
constexpr Real kOracleError = 0x1p-46L;

/// Names what is wrong with the answer, or nothing.
std::string fault(const Query& q, double d, double toi) {
  const Real size = size_of(q), error = kOracleError * size;
  const bool hit = toi != kNoCollision;
  std::ostringstream out;
  out << std::hexfloat;
  // The first time counts as collision, so just before it the distance is still larger than d.
  const Real end = hit ? static_cast<Real>(toi) : 1.0L;
  if (end > 0 && least_distance(q, end) < d - error) out << "late: d " << d << " toi " << toi;
  if (hit && distance_at(q, toi) > d + d / 64 + 0x1p-40L * size + error)
    out << "early: d " << d << " toi " << toi << " distance " << distance_at(q, toi);
  return out.str();
}

class MinSeparation : public ::testing::TestWithParam<int> {};

TEST_P(MinSeparation, IsNeverLateAndEarlyByNoMoreThanItsBound) {
  Random r(100 + static_cast<unsigned>(GetParam()));
  constexpr int kQueries = 700;
  int hits = 0, clear = 0, failures = 0;
  for (int i = 0; i < kQueries && failures < 3; ++i) {
    const Query q = hard(r, GetParam(), kind_of(i));
    const double d = size_of(q) * std::ldexp(real(r, 0.5, 1.0), -integer(r, 0, 40));
    const double toi = time_of(*make_ccd_separation(d), q);
    (toi == kNoCollision ? clear : hits) += 1;
    const std::string wrong = fault(q, d, toi);
    if (wrong.empty()) continue;
    ++failures;
    ADD_FAILURE() << "query " << i << " " << wrong << ": " << text(q);
  }
  EXPECT_GT(hits, kQueries / 50);
  const bool made_to_touch = GetParam() >= 1 && GetParam() <= 4;
  EXPECT_GT(clear, made_to_touch ? -1 : kQueries / 50);
}

INSTANTIATE_TEST_SUITE_P(Hard, MinSeparation, ::testing::Range(0, kCategories));

/// Turning primitives that stay near: where plain advancement creeps.
Query pinwheel(Random& r, ContactKind kind, double d) {
  Query q = reals(r, kind);
  // The point (an end of the first edge) stays near a fixed place of the second primitive, which
  // turns about it.
  Vec3 weight(real(r, 0.0, 1.0), real(r, 0.0, 1.0), real(r, 0.0, 1.0));
  weight /= weight.sum();
  for (auto* x : {&q.x_t0, &q.x_t1}) {
    auto& y = *x;
    if (kind == ContactKind::edge_edge) {
      const Vec3 n = (y[1] - y[0]).cross(y[3] - y[2]).normalized();
      const Vec3 shift = 0.5 * (y[0] + y[1]) - (0.25 * y[2] + 0.75 * y[3]) - d * n;
      y[2] += shift, y[3] += shift;
    } else {
      const Vec3 n = (y[2] - y[1]).cross(y[3] - y[1]).normalized();
      y[0] = weight[0] * y[1] + weight[1] * y[2] + weight[2] * y[3] + d * n;
    }
  }
  return q;
}

/// A point that stays beside a turning side of the triangle, outside.
Query beside_turning_side(Random& r, double d) {
  Query q = reals(r, ContactKind::point_triangle);
  const double along = real(r, 0.1, 0.9), angle = real(r, -1.6, 1.6);
  for (auto* x : {&q.x_t0, &q.x_t1}) {
    auto& y = *x;
    const Vec3 side = y[2] - y[1], n = side.cross(y[3] - y[1]).normalized();
    const Vec3 outward = side.cross(n).normalized();
    y[0] = y[1] + along * side + d * (std::cos(angle) * outward + std::sin(angle) * n);
  }
  return q;
}

TEST(MinSeparation, APointBesideATurningSideGetsAnAnswerWithinTheBound) {
  Random r(40);
  int clear = 0;
  for (int i = 0; i < 300; ++i) {
    const double d = std::ldexp(1.0, -integer(r, 4, 24));
    const Query q = beside_turning_side(r, 1.3 * d);
    const double toi = time_of(*make_ccd_separation(d), q);
    clear += toi == kNoCollision ? 1 : 0;
    ASSERT_EQ(fault(q, d, toi), "") << text(q);
  }
  EXPECT_GT(clear, 30);
}

TEST(MinSeparation, TurningPrimitivesThatStayNearGetAnAnswerWithinTheBound) {
  Random r(41);
  int clear = 0;
  for (int i = 0; i < 600; ++i) {
    const double d = std::ldexp(1.0, -integer(r, 4, 30));
    const Query q = pinwheel(r, kind_of(i), 1.3 * d);
    const double toi = time_of(*make_ccd_separation(d), q);
    clear += toi == kNoCollision ? 1 : 0;
    ASSERT_EQ(fault(q, d, toi), "") << text(q);
  }
  EXPECT_GT(clear, 60);
}

TEST(MinSeparation, AFallingPointIsStoppedAtTheKnownTime) {
  for (const double d : {0.5, 0.1, 1e-3, 1e-6, 1e-9}) {
    const Query q{ContactKind::point_triangle,
                  {Vec3(0.25, 0.25, 1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)},
                  {Vec3(0.25, 0.25, -1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}};
    const double toi = time_of(*make_ccd_separation(d), q);
    const Real truth = (1.0L - d) / 2.0L;
    EXPECT_LE(toi, truth);
    EXPECT_GT(toi, truth - d / 128 - 0x1p-40);
  }
}

TEST(MinSeparation, WhatRestsWithinTheSeparationCollidesAtOnce) {
  Random r(43);
  for (int i = 0; i < 2000; ++i) {
    Query q = hard(r, i % kCategories, kind_of(i));
    if (i % 3 == 0) q.x_t1 = q.x_t0;
    const double at_start = static_cast<double>(distance_at(q, 0));
    ASSERT_EQ(time_of(*make_ccd_separation(at_start), q), 0.0) << text(q);
  }
}

TEST(MinSeparation, WhatRestsOutsideTheBoundNeverCollides) {
  Random r(44);
  for (int i = 0; i < 2000; ++i) {
    Query q = hard(r, i % kCategories, kind_of(i));
    q.x_t1 = q.x_t0;
    const double size = size_of(q), distance = static_cast<double>(distance_at(q, 0));
    const double d = (distance - 0x1p-39 * size) / (1.0 + 1.0 / 64);
    if (!(d > 0.0)) continue;
    ASSERT_EQ(time_of(*make_ccd_separation(d), q), kNoCollision) << distance << text(q);
  }
}

TEST(MinSeparation, ScalingByAPowerOfTwoNeverChangesTheAnswer) {
  Random r(45);
  for (int i = 0; i < 4000; ++i) {
    Query q = hard(r, i % kCategories, kind_of(i));
    const double d = size_of(q) * std::ldexp(real(r, 0.5, 1.0), -integer(r, 1, 30));
    const double toi = time_of(*make_ccd_separation(d), q);
    const double factor = std::ldexp(1.0, integer(r, -900, 900));
    for_each_coordinate(q, [&](double c) { return c * factor; });
    ASSERT_EQ(time_of(*make_ccd_separation(factor * d), q), toi) << text(q);
  }
}

TEST(MinSeparation, MotionSharedByAllVerticesChangesNothing) {
  Random r(46);
  for (int i = 0; i < 2000; ++i) {
    Query q = hard(r, i % 4, kind_of(i));
    const double d = size_of(q) * std::ldexp(real(r, 0.5, 1.0), -integer(r, 1, 20));
    const double toi = time_of(*make_ccd_separation(d), q);
    for (Vec3& v : q.x_t0) v += Vec3(512, -256, 128);
    for (Vec3& v : q.x_t1) v -= Vec3(1024, 16384, 4096);
    ASSERT_EQ(time_of(*make_ccd_separation(d), q), toi) << text(q);
  }
}

TEST(MinSeparation, ALargerOneIsNeverAnsweredLater) {
  Random r(47);
  for (int i = 0; i < 3000; ++i) {
    const Query q = hard(r, i % kCategories, kind_of(i));
    const double d = size_of(q) * std::ldexp(1.0, -integer(r, 1, 20));
    // By more than the early bound of the smaller one.
    const double near = time_of(*make_ccd_separation(d), q);
    const double far = time_of(*make_ccd_separation(1.1 * d), q);
    ASSERT_LE(far, near) << text(q);
  }
}

TEST(MinSeparation, TheNormalOfAContactIsTheDirectionBetweenTheClosestPoints) {
  // A point nears the side x = 0 of a triangle from outside, almost in its plane.
  constexpr double d = 0.125;
  const std::vector<Vec3> point_t0{Vec3(-1, 0, 0.01)}, point_t1{Vec3(1, 0, 0.01)};
  const std::vector<Vec3> corners{Vec3(0, -1, 0), Vec3(0, 1, 0), Vec3(1, 0, 0)};
  const std::vector<Triangle> triangles{Triangle{0, 1, 2}};
  const SurfaceView point{point_t0, point_t1, {}, {}};
  const SurfaceView triangle{corners, corners, {}, triangles};
  for (const bool swapped : {false, true}) {
    CandidatePairs pairs;
    (swapped ? pairs.triangle_point : pairs.point_triangle).push_back({0, 0});
    std::vector<Contact> contacts;
    make_ccd_separation(d)->find_contacts(swapped ? triangle : point, swapped ? point : triangle,
                                          pairs, contacts);
    ASSERT_EQ(contacts.size(), 1u);
    const Contact& c = contacts[0];
    const Vec3 way = Vec3(2.0 * c.toi - 1.0, 0, 0.01);
    EXPECT_NEAR((c.normal - way.normalized()).norm(), 0.0, 1e-12);
    EXPECT_NEAR(way.norm(), d, d / 64);
    EXPECT_NEAR(c.gap, Vec3(-1, 0, 0.01).norm(), 1e-12);
  }
}

TEST(MinSeparation, CoordinatesAtTheEndsOfTheRangeGetAnAnswer) {
  for (const double size : {0x1p-1074, 0x1p-1030, 1e-300, 1.0, 1e300, 0x1.8p1023}) {
    const Query q{
        ContactKind::edge_edge,
        {Vec3(-size, 0, size), Vec3(size, 0, size), Vec3(0, -size, 0), Vec3(0, size, 0)},
        {Vec3(-size, 0, -size), Vec3(size, 0, -size), Vec3(0, -size, 0), Vec3(0, size, 0)}};
    const double toi = time_of(*make_ccd_separation(0.0), q);
    EXPECT_LE(toi, 0.5) << size;
    EXPECT_GT(toi, 0.499) << size;
  }
}

}  // namespace
}  // namespace selvedge::min_separation_test
