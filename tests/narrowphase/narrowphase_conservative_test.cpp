// SPDX-License-Identifier: MIT
// The conservative methods (inclusion, additive) against the exact one; root parity against the
// count of contacts.
#include <gtest/gtest.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/cubic.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "hard_queries.h"

namespace selvedge::narrowphase_conservative_test {
namespace {

using namespace hard_queries;

// ---------------------------------------------------------------------------------------------
// Conservative methods against the exact one

struct Conservative {
  const char* name;
  unsigned seed;
  std::function<std::unique_ptr<NarrowPhase>()> make;
};

/// Small budgets: what runs out must be as safe as what is decided, and quicker to test.
const std::vector<Conservative> kMethods{
    {"inclusion_time_first", 17,
     [] { return make_ccd_inclusion(CcdInclusionConfig{.max_boxes = 200}); }},
    {"inclusion_breadth_first", 18,
     [] {
       return make_ccd_inclusion(
           CcdInclusionConfig{.max_boxes = 200, .order = CcdInclusionConfig::Order::breadth_first});
     }},
    {"inclusion_coarse", 19,
     [] { return make_ccd_inclusion(CcdInclusionConfig{.tolerance = 0x1p-6, .max_boxes = 200}); }},
    {"additive", 20, [] { return make_ccd_additive(CcdAdditiveConfig{.max_steps = 100}); }},
    {"additive_close", 21,
     [] { return make_ccd_additive(CcdAdditiveConfig{.gap = 1e-3, .max_steps = 100}); }},
    {"separation_zero", 22, [] { return make_ccd_separation(0.0); }},
    {"separation_tiny", 23, [] { return make_ccd_separation(1e-12); }},
};

void PrintTo(const Conservative& method, std::ostream* out) { *out << method.name; }

class ConservativeMethod : public ::testing::TestWithParam<Conservative> {};

TEST_P(ConservativeMethod, IsNeverLaterThanTheTrueTimeOnHardQueries) {
  const auto method = GetParam().make();
  const auto exact = make_ccd_exact();
  EXPECT_TRUE(method->traits().misses_nothing);
  constexpr int kQueries = 8400;  // of each of the seven: 58,800 in all
  Random r(GetParam().seed);
  int hits = 0, clear = 0, failures = 0;
  for (int i = 0; i < kQueries && failures < 5; ++i) {
    Query q = hard(r, i / 2 % kCategories, kind_of(i));
    if (i % 5 == 0) q = rescaled(r, q);
    const double truth = time_of(*exact, q), found = time_of(*method, q);
    hits += truth != kNoCollision ? 1 : 0;
    clear += found == kNoCollision ? 1 : 0;
    if (found <= truth && (found == kNoCollision || found >= 0.0)) continue;
    ++failures;
    ADD_FAILURE() << "query " << i << ": " << found << " instead of " << truth << ": " << text(q);
  }
  EXPECT_GT(hits, kQueries / 5);
  // A method that always says "at once" would pass too.
  EXPECT_GT(clear, kQueries / 5);
}

/// Primitives along the z axis whose traces in the x-y plane meet at t = 1/4 exactly, though none
/// of the differences of their coordinates is a double: 51 bits of different size, times -3 at t
/// = 1.
Query meeting_by_a_hair(Random& r, ContactKind kind) {
  const auto trace = [&] {
    return std::ldexp(std::floor(real(r, -1.0, 1.0) * 0x1p51), integer(r, -70, -51));
  };
  Query q;
  q.kind = kind;
  for (int k = 0, second = kind == ContactKind::edge_edge ? 2 : 1; k < 4; ++k) {
    if (k == 0 || k == second) q.x_t0[k] = Vec3(trace(), trace(), 0.0);
    if (k != 0 && k != second) q.x_t0[k] = q.x_t0[k - 1] + Vec3(0, 0, 1.0);
    q.x_t1[k] = Vec3(-3.0 * q.x_t0[k].x(), -3.0 * q.x_t0[k].y(), q.x_t0[k].z());
  }
  return q;
}

TEST_P(ConservativeMethod, FindsContactThatRoundingOfTheCoordinatesWouldLose) {
  const auto method = GetParam().make();
  const auto exact = make_ccd_exact();
  Random r(20);
  for (int i = 0; i < 1000; ++i) {
    const Query q = meeting_by_a_hair(r, kind_of(i));
    ASSERT_EQ(time_of(*exact, q), 0.25) << text(q);
    ASSERT_LE(time_of(*method, q), 0.25) << text(q);
  }
}

TEST_P(ConservativeMethod, DecidesNearlyAllQueriesInGeneralPosition) {
  const auto method = GetParam().make();
  const auto exact = make_ccd_exact();
  Random r(18);
  int alarms = 0, negatives = 0;
  for (int i = 0; i < 2000; ++i) {
    const Query q = reals(r, kind_of(i));
    if (time_of(*exact, q) != kNoCollision) continue;
    ++negatives;
    alarms += time_of(*method, q) != kNoCollision ? 1 : 0;
  }
  EXPECT_LT(alarms, negatives / 5) << negatives;
}

INSTANTIATE_TEST_SUITE_P(Methods, ConservativeMethod, ::testing::ValuesIn(kMethods),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(CcdInclusion, FindsTheTimeWithinItsToleranceInGeneralPosition) {
  const auto exact = make_ccd_exact();
  const auto time_first = make_ccd_inclusion(CcdInclusionConfig{});
  const auto breadth_first =
      make_ccd_inclusion(CcdInclusionConfig{.order = CcdInclusionConfig::Order::breadth_first});
  Random r(19);
  int hits = 0;
  for (int i = 0; i < 1000; ++i) {
    const Query q = reals(r, kind_of(i));
    const double truth = time_of(*exact, q);
    if (truth == kNoCollision) continue;
    ++hits;
    const double found = time_of(*time_first, q);
    EXPECT_EQ(found, time_of(*breadth_first, q)) << text(q);
    EXPECT_LE(found, truth);
    // The last box is about 2^-20 / speed long; grazing contact makes more of it.
    EXPECT_GT(found, truth - 1e-2) << text(q);
  }
  EXPECT_GT(hits, 30);
}

TEST(CcdInclusion, SaysCollidesAtTheEarliestOpenTimeWhenBoxesRunOut) {
  // Edges that slide past one another in their common line, 2^-30 apart.
  const Query q{ContactKind::edge_edge,
                {Vec3(0, 0, 0), Vec3(1, 1, 1), Vec3(0, 0, 0x1p-30), Vec3(1, 1, 1 + 0x1p-30)},
                {Vec3(1, 1, 1), Vec3(2, 2, 2), Vec3(0, 0, 0x1p-30), Vec3(1, 1, 1 + 0x1p-30)}};
  EXPECT_EQ(time_of(*make_ccd_exact(), q), kNoCollision);
  EXPECT_EQ(
      time_of(*make_ccd_inclusion(CcdInclusionConfig{.tolerance = 0x1p-40, .max_boxes = 50}), q),
      0.0);
}

TEST(CcdAdditive, StopsShortOfContactByItsPartOfTheFirstDistance) {
  // A point falls from 1 m to -1 m through a triangle.
  const Query q{ContactKind::point_triangle,
                {Vec3(0.25, 0.25, 1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)},
                {Vec3(0.25, 0.25, -1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}};
  for (const double gap : {0.5, 0.1, 0.001}) {
    const double t = time_of(*make_ccd_additive(CcdAdditiveConfig{.gap = gap}), q);
    const double left = 1.0 - 2.0 * t;
    EXPECT_GT(left, 0.0);
    EXPECT_LE(left, gap);
  }
}

TEST(CcdAdditive, RaisesAFalseAlarmWhereThePrimitivesComeNear) {
  const Query q{ContactKind::point_triangle,
                {Vec3(0.05, 0.25, 1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)},
                {Vec3(0.65, 0.25, 0.05), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}};
  EXPECT_NE(time_of(*make_ccd_additive(), q), kNoCollision);
  EXPECT_EQ(time_of(*make_ccd_additive(CcdAdditiveConfig{.gap = 0.01}), q), kNoCollision);
}

TEST(Config, IsRefusedWithASentenceWhereItMakesNoSense) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto registry = narrow_phases();
  for (const double d : {-1.0, nan, static_cast<double>(kNoCollision)}) {
    EXPECT_THROW(make_ccd_separation(d), std::invalid_argument);
    for (const char* name : {"ccd_exact", "ccd_inclusion", "ccd_additive", "ccd_root_parity"})
      EXPECT_THROW(registry.at(name)(MethodOptions{{"min_separation", d}}), std::invalid_argument)
          << name;
  }
  EXPECT_THROW(registry.at("ccd_root_parity")(MethodOptions{{"min_separation", 1e-3}}),
               std::invalid_argument);
  EXPECT_THROW(registry.at("ccd_inclusion")(MethodOptions{{"tolerance", 2.0}}),
               std::invalid_argument);
  EXPECT_THROW(registry.at("ccd_inclusion")(MethodOptions{{"tolerance", 1e-15}}),
               std::invalid_argument);
  EXPECT_THROW(make_ccd_inclusion(CcdInclusionConfig{.max_boxes = 0}), std::invalid_argument);
  EXPECT_THROW(registry.at("ccd_additive")(MethodOptions{{"tolerance", 1.0}}),
               std::invalid_argument);
  EXPECT_THROW(make_ccd_additive(CcdAdditiveConfig{.max_steps = 0}), std::invalid_argument);
}

TEST(Config, NonFiniteVerticesAreRefusedByName) {
  Random r(1);
  for (const char* name : {"ccd_exact", "ccd_inclusion", "ccd_additive", "ccd_root_parity"}) {
    const auto registry = narrow_phases();
    const auto& entry = registry.at(name);
    const auto method = entry(known_options(entry.options(), {{"min_separation", 0.01}}));
    Query q = reals(r, ContactKind::edge_edge);
    q.x_t1[2].y() = std::numeric_limits<double>::infinity();
    EXPECT_THROW(time_of(*method, q), std::invalid_argument) << name;
  }
}

// ---------------------------------------------------------------------------------------------
// Root parity

/// Contacts of a query in general position, counted at the roots of the coplanarity cubic; -1 if a
/// root is too near a boundary for doubles.
int count_contacts(const Query& q) {
  constexpr double kUnclear = 1e-7;
  int count = 0;
  for (const CubicRoot& root : coplanarity_roots(q).roots) {
    const double d = static_cast<double>(distance_at(q, root.lo));
    if (root.lo < kUnclear || root.lo > 1.0 - kUnclear) return -1;
    if (d > 1e-13 && d < kUnclear) return -1;
    count += d <= 1e-13 ? 1 : 0;
  }
  return count;
}

TEST(RootParity, IsTheParityOfTheNumberOfContactsInGeneralPosition) {
  const auto method = make_ccd_root_parity();
  EXPECT_FALSE(method->traits().gives_time);
  EXPECT_FALSE(method->traits().misses_nothing);
  Random r(51);
  std::array<int, 4> seen{};
  for (int i = 0; i < 20000; ++i) {
    const Query q = reals(r, kind_of(i));
    const int contacts = count_contacts(q);
    if (contacts < 0) continue;
    ++seen[contacts];
    const double t = time_of(*method, q);
    ASSERT_EQ(t, contacts % 2 == 1 ? 0.0 : kNoCollision) << contacts << ": " << text(q);
  }
  for (const int n : {0, 1, 2}) EXPECT_GT(seen[n], 20) << n << " contacts";
}

TEST(RootParity, ContactAtTheEndsOfTheStepIsAlwaysFound) {
  const auto method = make_ccd_root_parity();
  Random r(52);
  for (int i = 0; i < 8000; ++i) {
    const Query q = hard(r, 1 + i % 2, kind_of(i / 2));
    ASSERT_EQ(time_of(*method, q), 0.0) << i << ": " << text(q);
  }
}

TEST(RootParity, ContactInsideTheStepIsFoundUnlessEven) {
  const auto method = make_ccd_root_parity();
  const auto exact = make_ccd_exact();
  Random r(53);
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    const Query q = hard(r, i % kCategories, kind_of(i / kCategories));
    const bool truth = time_of(*exact, q) != kNoCollision;
    if (!truth || time_of(*method, q) == 0.0) {
      hits += truth ? 1 : 0;
      continue;
    }
    // A miss must have at least two roots, with multiplicity.
    int roots = 0;
    for (const CubicRoot& root : coplanarity_roots(q).roots) roots += root.multiplicity;
    ASSERT_GE(roots, 2) << text(q);
  }
  EXPECT_GT(hits, 4000);
}

TEST(RootParity, MissesAPointThatPassesTheTriangleAndReturns) {
  // The point rises and the plane turns so that they meet at t = 1/4 and t = 3/4.
  const auto height = [](double t) { return (t - 0.25) * (t - 0.75); };
  // z of the point is t - 1/4; the triangle's plane tilts: z = x (1 - t) there, x = 2 t - ...
  Query q{ContactKind::point_triangle,
          {Vec3(0, 0, 0.1875), Vec3(-8, -8, 0), Vec3(8, -8, 0), Vec3(0, 8, 0)},
          {Vec3(1, 0, 0.1875), Vec3(-8, -8, -8), Vec3(8, -8, 8), Vec3(0, 8, 0)}};
  // On the path x = t the plane is at z = t * t, the point at z = 0.1875 + c t: with c = 1 - 1 = 0
  // the difference is 0.1875 - t * t; a slope of the point of 1 makes it -(t^2 - t + 3/16).
  q.x_t0[0].z() = -0.1875, q.x_t1[0].z() = 1.0 - 0.1875;
  EXPECT_EQ(height(0.0), 0.1875);
  EXPECT_EQ(time_of(*make_ccd_exact(), q), 0.25);
  EXPECT_EQ(time_of(*make_ccd_root_parity(), q), kNoCollision);
}

TEST(RootParity, CoordinatesTooUnlikeForExpansionsCountAsHit) {
  Query q{ContactKind::point_triangle,
          {Vec3(0.25, 0.25, 1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)},
          {Vec3(0.25, 0.25, -1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}};
  EXPECT_EQ(time_of(*make_ccd_root_parity(), q), 0.0);
  q.x_t0[0] = Vec3(4, 4, 1), q.x_t1[0] = Vec3(4, 4, -1);
  EXPECT_EQ(time_of(*make_ccd_root_parity(), q), kNoCollision);
  q.x_t0[1].x() = 1e-200;
  EXPECT_EQ(time_of(*make_ccd_root_parity(), q), kNoCollision);  // apart along an axis
  q.x_t0[0] = q.x_t1[0] = Vec3(0.9, 0.9, 0.5), q.x_t1[0].z() = -0.5;
  EXPECT_EQ(time_of(*make_ccd_root_parity(), q), 0.0);
}

}  // namespace
}  // namespace selvedge::narrowphase_conservative_test
