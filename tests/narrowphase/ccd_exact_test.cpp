// SPDX-License-Identifier: MIT
#include "ccd_queries.h"

#include <gtest/gtest.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/detail/polynomial_box.h>
#include <selvedge/narrowphase/query_file.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge::ccd_exact_test {
namespace {

using ccd_queries::falling_point, ccd_queries::families, ccd_queries::Family, ccd_queries::hex_text;
using ccd_queries::integer, ccd_queries::kind_of_index, ccd_queries::Random, ccd_queries::real;
using ccd_queries::Truth, ccd_queries::truth_of;

using detail::Box, detail::isolate_roots, detail::Polynomial, detail::restrict_to, detail::Root;

namespace fs = std::filesystem;
constexpr double kInf = std::numeric_limits<double>::infinity();

/// The first time of contact, or kNoCollision.
double time_of(const Query& q) {
  double toi = kNoCollision;
  return make_ccd_exact()->collides(q, toi) ? toi : kNoCollision;
}

// ---------------------------------------------------------------------------------------------
// Public queries with known truth

fs::path shared_folder() {
  if (const char* named = std::getenv("SELVEDGE_SHARED")) return named;
  return fs::path(SELVEDGE_SOURCE_DIR) / ".." / "shared";
}

TEST(CcdExact, HasNoMissAndNoFalseAlarmOnPublicQueries) {
  const fs::path root = shared_folder() / "data" / "ccd";
  if (!fs::exists(root)) GTEST_SKIP() << "the query files are not there: " << root;
  const auto method = make_ccd_exact();
  std::size_t queries = 0;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    const std::string name = entry.path().string();
    if (!name.ends_with(".csv") || name.ends_with(".toi.csv")) continue;
    const bool face = name.find("vertex-face") != std::string::npos;
    const QuerySet known =
        read_queries(entry.path(), face ? ContactKind::point_triangle : ContactKind::edge_edge);
    std::vector<double> toi(known.queries.size());
    method->find_times(known.queries, toi);
    for (std::size_t i = 0; i < toi.size(); ++i) {
      EXPECT_EQ(toi[i] != kNoCollision, known.truth[i] == 1) << name << " query " << i;
      if (!known.toi.empty()) {
        EXPECT_EQ(toi[i], known.toi[i].lo) << name << " query " << i;
      }
    }
    queries += known.queries.size();
  }
  EXPECT_EQ(queries, 9702u);
}

// ---------------------------------------------------------------------------------------------
// Against the independent oracle

/// 55 families make 220,000 queries. SELVEDGE_CCD_QUERIES asks more or fewer of each.
int queries_per_family() {
  const char* named = std::getenv("SELVEDGE_CCD_QUERIES");
  return named != nullptr ? std::atoi(named) : 4000;
}

std::vector<Query> queries_of(const Family& family, Random& r, int n) {
  std::vector<Query> queries;
  for (int i = 0; i < n; ++i) queries.push_back(family.make(r, kind_of_index(i)));
  return queries;
}

class CcdExactFamily : public ::testing::TestWithParam<int> {
 protected:
  const Family& family() const { return families()[GetParam()]; }
  unsigned seed() const { return 1000 + static_cast<unsigned>(GetParam()); }
};

TEST_P(CcdExactFamily, GetsVerdictAndTimeOfTheOracle) {
  const int n = queries_per_family();
  Random r(seed());
  const std::vector<Query> queries = queries_of(family(), r, n);
  std::vector<double> toi(queries.size());
  make_ccd_exact()->find_times(queries, toi);
  int hits = 0, failures = 0;
  for (std::size_t i = 0; i < queries.size() && failures < 5; ++i) {
    const Truth truth = truth_of(queries[i]);
    hits += truth.touches ? 1 : 0;
    if (toi[i] == truth.toi_lo) continue;
    ++failures;
    ADD_FAILURE() << "seed " << seed() << " query " << i << ": time " << toi[i] << ", truth "
                  << truth.toi_lo << ": " << hex_text(queries[i]);
  }
  // A family without collisions would prove nothing.
  EXPECT_GT(hits, n / 200);
}

std::string family_name(const ::testing::TestParamInfo<int>& info) {
  return std::string(families()[info.param].name);
}

INSTANTIATE_TEST_SUITE_P(All, CcdExactFamily,
                         ::testing::Range(0, static_cast<int>(families().size())), family_name);

/// Queries of all families side by side.
std::vector<Query> mixed_queries(unsigned seed, int per_family) {
  Random r(seed);
  std::vector<Query> queries;
  for (int i = 0; i < per_family; ++i)
    for (const Family& family : families())
      queries.push_back(family.make(r, kind_of_index(integer(r, 0, 1))));
  return queries;
}

// ---------------------------------------------------------------------------------------------
// Time

/// Small integers, of which up to three are replaced by numbers of another magnitude; every fourth
/// query ends where it starts, every fourth collapses to a point, every fifth lies in a plane,
/// every fifth on a line.
std::vector<Query> spread_queries(unsigned seed, int n) {
  constexpr double kOther[] = {5e-324, -5e-324, 1e-310, 1e-300, 1e-160, 1e-60,
                               -1e-18, 1e18,    1e200,  1e300,  -8e307};
  Random r(seed);
  std::vector<Query> queries;
  for (int i = 0; i < n; ++i) {
    Query q = ccd_queries::grid(r, kind_of_index(i), 4);
    if (i % 8 < 2) q.x_t1 = q.x_t0;
    if (i % 8 >= 6) q.x_t1.fill(q.x_t1[0]);
    for (auto* x : {&q.x_t0, &q.x_t1})
      for (Vec3& v : *x) {
        if (i % 5 >= 3) v.z() = i % 5 == 3 ? v.x() - v.y() : 0.0;
        if (i % 5 == 4) v.y() = 0.0;
      }
    for (int k = integer(r, 1, 3); k-- > 0;) {
      auto& x = integer(r, 0, 1) == 0 ? q.x_t0 : q.x_t1;
      x[integer(r, 0, 3)][integer(r, 0, i % 5 == 4 ? 0 : 2)] = kOther[integer(r, 0, 10)];
    }
    queries.push_back(q);
  }
  return queries;
}

/// Seconds of this thread.
double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

TEST(CcdExact, CoordinatesOfVeryDifferentMagnitudeTakeAtMostAMillisecond) {
  // The worst of 100,000 such queries takes 0.4 ms. Sanitizers take many times as long.
#ifdef __SANITIZE_ADDRESS__
  constexpr double kMost = 0.050;
#else
  constexpr double kMost = 0.001;
#endif
  // Another program on the processor's other thread can double a time, so a long one is taken
  // again.
  constexpr double kLong = 0.0003;
  const auto method = make_ccd_exact();
  const char* asked = std::getenv("SELVEDGE_CCD_QUERIES");
  const std::vector<Query> queries = spread_queries(17, asked != nullptr ? std::atoi(asked) : 2000);
  double worst = 0.0;
  for (const Query& q : queries) {
    double least = kMost * 100.0, toi = 0.0;
    for (int repeat = 0; repeat < 9 && least > kLong; ++repeat) {
      const double begin = thread_seconds();
      method->collides(q, toi);
      least = std::min(least, thread_seconds() - begin);
    }
    worst = std::max(worst, least);
    EXPECT_LT(least, kMost) << hex_text(q);
  }
  std::printf("the longest of %zu queries took %.3f ms\n", queries.size(), 1e3 * worst);
}

/// With some hundred bits, of which most are zero in every second number.
BigInt long_number(Random& r, int i) {
  BigInt number(integer(r, -9, 9));
  for (int k = integer(r, 0, 6); k-- > 0;)
    number = (number << integer(r, 1, i % 2 == 0 ? 200 : 30)) + BigInt(integer(r, -999, 999));
  return number;
}

TEST(LongNumbers, TheLeading106BitsAreThoseOfTheNumber) {
  Random r(5);
  for (int i = 0; i < 2000; ++i) {
    const BigInt number = long_number(r, i);
    int exponent = 0;
    double rest = 0.0;
    const double mantissa = number.mantissa(exponent, rest);
    EXPECT_EQ(exponent, number.bit_length());
    if (number.is_zero()) continue;
    EXPECT_EQ(mantissa < 0.0, number.sign() < 0);
    // number = (mantissa + rest) 2^exponent + a remainder of the same sign, below 2^(exponent-106).
    const auto part = [&](double x) { return BigInt::from_double(x, -exponent - 200); };
    const BigInt remainder = (number << 200) - part(mantissa) - part(rest);
    EXPECT_GE(std::abs(mantissa), 0.5);
    EXPECT_LT(std::abs(mantissa), 1.0);
    EXPECT_LT(std::abs(rest), 0x1p-53);
    EXPECT_NE(remainder.sign(), -number.sign());
    EXPECT_LE(remainder.bit_length(), exponent + 200 - 106);
  }
}

/// p at the time k / 2^m, times 2^(m degree).
BigInt value_at(const Polynomial<BigInt>& p, const BigInt& k, int m) {
  const BigInt rest = (BigInt(1) << m) - k;
  BigInt sum;
  for (int i = 0; i <= p.degree; ++i) {
    BigInt term = p.c[i];
    for (int j = 0; j < p.degree; ++j) term = term * (j < i ? k : rest);
    sum = sum + term;
  }
  return sum;
}

TEST(LongNumbers, APolynomialRestrictedToABoxHasTheValuesOfTheWhole) {
  Random r(6);
  for (int i = 0; i < 500; ++i) {
    Polynomial<BigInt> p;
    p.degree = 1 + i % 4;
    for (int j = 0; j <= p.degree; ++j) p.c[j] = long_number(r, i);
    const int m = integer(r, 1, 100);
    const Box<BigInt> box{BigInt(integer(r, 0, 1)) << integer(r, 0, m - 1), BigInt(1), m};
    const Polynomial<BigInt> local = restrict_to(p, box);
    ASSERT_EQ(local.degree, p.degree);
    // At 5/8 of the box, which is (8 k + 5 width) / 2^(m+3).
    const BigInt whole = value_at(p, (box.k << 3) + BigInt(5) * box.width, m + 3);
    EXPECT_TRUE((value_at(local, BigInt(5), 3) - whole).is_zero()) << i;
    EXPECT_TRUE((local.c[0] - value_at(p, box.k, m)).is_zero()) << i;
    EXPECT_TRUE((local.c[p.degree] - value_at(p, box.end(), m)).is_zero()) << i;
  }
}

TEST(LongNumbers, TheLowerBoundOfARootIsNotAboveIt) {
  Random r(7);
  int isolated = 0;
  for (int i = 0; i < 2000; ++i) {
    Polynomial<BigInt> p;
    p.degree = 1 + i % 3;
    for (int j = 0; j <= p.degree; ++j) p.c[j] = long_number(r, i);
    if (p.is_zero()) continue;
    std::vector<Root<BigInt>> roots;
    isolate_roots(p, roots);
    for (const Root<BigInt>& root : roots) {
      bool exact = false;
      const double floor = root.floor(exact), bound = root.lower_bound();
      EXPECT_LE(bound, floor);
      EXPECT_GE(bound, 0.0);
      isolated += bound > 0.0 && bound > floor * (1.0 - 1e-14) ? 1 : 0;
    }
  }
  EXPECT_GT(isolated, 100) << "bounds that say something";
}

TEST(CcdExact, CoordinatesOfVeryDifferentMagnitudeHaveVerdictAndTimeOfTheOracle) {
  const std::vector<Query> queries = spread_queries(18, 300);
  std::vector<double> toi(queries.size());
  make_ccd_exact()->find_times(queries, toi);
  int hits = 0;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const Truth truth = truth_of(queries[i]);
    hits += truth.touches ? 1 : 0;
    EXPECT_EQ(toi[i], truth.toi_lo) << hex_text(queries[i]);
  }
  EXPECT_GT(hits, 10);
}

TEST(CcdExact, TheOtherLanesOfAVectorNeverChangeVerdictOrTime) {
  std::vector<Query> queries = mixed_queries(71, 100);
  std::vector<double> together(queries.size()), alone(queries.size());
  const auto method = make_ccd_exact();
  for (std::size_t i = 0; i < queries.size(); ++i)
    method->find_times({&queries[i], 1}, {&alone[i], 1});
  for (int round = 0; round < 3; ++round) {
    method->find_times(queries, together);
    ASSERT_EQ(together, alone);
    std::reverse(queries.begin(), queries.end() - round);
    std::reverse(alone.begin(), alone.end() - round);
  }
}

TEST(CcdExact, EveryVectorWidthGivesTheSameTimes) {
  const std::vector<Query> queries = mixed_queries(72, 100);
  std::vector<double> narrow(queries.size()), wide(queries.size());
  make_ccd_exact({.vector_width = 2})->find_times(queries, narrow);
  for (const int width : {4, 8}) {
    make_ccd_exact({.vector_width = width})->find_times(queries, wide);
    EXPECT_EQ(narrow, wide) << "width " << width;
  }
}

// ---------------------------------------------------------------------------------------------
// The same through surfaces and pairs

TEST(FindContacts, OfAllFamiliesHaveTheOraclesVerdictsInPairOrder) {
  const std::vector<Query> queries = mixed_queries(73, 100);
  const ccd_queries::Scene scene = ccd_queries::scene_of(queries);
  std::vector<double> expected;
  for (const auto* list : {&scene.point_triangle, &scene.triangle_point, &scene.edge_edge}) {
    const std::size_t before = expected.size();
    for (const std::size_t i : *list)
      if (const Truth truth = truth_of(queries[i]); truth.touches) expected.push_back(truth.toi_lo);
    EXPECT_GT(expected.size() - before, 300u);
  }
  std::vector<Contact> contacts;
  make_ccd_exact()->find_contacts(scene.a.view(), scene.b.view(), scene.pairs, contacts);
  std::vector<double> found;
  for (const Contact& c : contacts) {
    found.push_back(c.toi);
    EXPECT_NEAR(c.normal.norm(), 1.0, 1e-14);
  }
  EXPECT_EQ(found, expected);
}

// ---------------------------------------------------------------------------------------------
// Symmetry

template <class Change>
void change_all(Query& q, const Change& change) {
  for (auto* x : {&q.x_t0, &q.x_t1})
    for (Vec3& v : *x) change(v);
}

bool equal(const Query& a, const Query& b) { return a.x_t0 == b.x_t0 && a.x_t1 == b.x_t1; }

/// The query times 2^exponent, if nothing is rounded.
std::optional<Query> scaled(const Query& q, int exponent) {
  Query out = q;
  const auto times = [&](int e) {
    change_all(out, [&](Vec3& v) {
      for (int i = 0; i < 3; ++i) v[i] = std::ldexp(v[i], e);
    });
  };
  times(exponent);
  const Query there = out;
  times(-exponent);
  return equal(out, q) ? std::optional(there) : std::nullopt;
}

/// The query shifted, if nothing is rounded.
std::optional<Query> shifted(const Query& q, const Vec3& shift) {
  Query out = q;
  change_all(out, [&](Vec3& v) { v += shift; });
  Query back = out;
  change_all(back, [&](Vec3& v) { v -= shift; });
  // Both roundings vanish: v + shift is a double, or x + shift - shift is no x.
  Query rest = out;
  for (int k = 0; k < 4; ++k) rest.x_t0[k] -= q.x_t0[k], rest.x_t1[k] -= q.x_t1[k];
  bool exact = equal(back, q);
  change_all(rest, [&](Vec3& v) { exact = exact && v == shift; });
  return exact ? std::optional(out) : std::nullopt;
}

/// Asks `check(query, toi)` for queries of all families.
template <class Check>
void for_queries_of_all_families(unsigned seed, int per_family, const Check& check) {
  const std::vector<Query> queries = mixed_queries(seed, per_family);
  std::vector<double> toi(queries.size());
  make_ccd_exact()->find_times(queries, toi);
  for (std::size_t i = 0; i < queries.size() && !::testing::Test::HasFailure(); ++i)
    check(queries[i], toi[i]);
}

TEST(CcdExactSymmetry, ScalingByAPowerOfTwoNeverChangesVerdictOrTime) {
  Random r(5);
  int scaled_queries = 0;
  for_queries_of_all_families(81, 200, [&](const Query& q, double toi) {
    const int range = integer(r, 0, 3) == 0 ? 1000 : 60;
    const auto other = scaled(q, integer(r, -range, range));
    if (!other) return;
    ++scaled_queries;
    EXPECT_EQ(time_of(*other), toi) << hex_text(q);
  });
  EXPECT_GT(scaled_queries, 8000);
}

TEST(CcdExactSymmetry, ShiftingByARepresentableAmountNeverChangesVerdictOrTime) {
  Random r(9);
  int shifted_queries = 0;
  for_queries_of_all_families(82, 300, [&](const Query& q, double toi) {
    const double unit = std::ldexp(1.0, integer(r, -20, 40));
    const Vec3 by(unit * integer(r, -9, 9), unit * integer(r, -9, 9), unit * integer(r, -9, 9));
    const auto other = shifted(q, by);
    if (!other) return;
    ++shifted_queries;
    EXPECT_EQ(time_of(*other), toi) << hex_text(q) << "\nby " << by.transpose();
  });
  EXPECT_GT(shifted_queries, 4000);
}

TEST(CcdExactSymmetry, RelabellingNeverChangesVerdictOrTime) {
  Random r(6);
  for_queries_of_all_families(83, 300, [&](const Query& q, double toi) {
    std::array<int, 4> order{0, 1, 2, 3};
    if (q.kind == ContactKind::point_triangle) {
      std::shuffle(order.begin() + 1, order.end(), r);
    } else {
      if (integer(r, 0, 1) != 0) std::swap(order[0], order[1]);
      if (integer(r, 0, 1) != 0) std::swap(order[2], order[3]);
      if (integer(r, 0, 1) != 0) order = {order[2], order[3], order[0], order[1]};
    }
    Query other = q;
    for (int k = 0; k < 4; ++k) other.x_t0[k] = q.x_t0[order[k]], other.x_t1[k] = q.x_t1[order[k]];
    EXPECT_EQ(time_of(other), toi) << hex_text(q);
  });
}

TEST(CcdExactSymmetry, MirrorsAndOtherOrdersOfTheAxesNeverChangeVerdictOrTime) {
  Random r(10);
  for_queries_of_all_families(84, 300, [&](const Query& q, double toi) {
    std::array<int, 3> axis{0, 1, 2};
    std::shuffle(axis.begin(), axis.end(), r);
    const Vec3 flip(integer(r, 0, 1) * 2 - 1, integer(r, 0, 1) * 2 - 1, integer(r, 0, 1) * 2 - 1);
    Query other = q;
    change_all(other, [&](Vec3& v) {
      v = Vec3(flip[0] * v[axis[0]], flip[1] * v[axis[1]], flip[2] * v[axis[2]]);
    });
    EXPECT_EQ(time_of(other), toi) << hex_text(q);
  });
}

TEST(CcdExactSymmetry, TimeReversalNeverChangesTheVerdict) {
  for_queries_of_all_families(85, 300, [&](const Query& q, double toi) {
    Query other = q;
    std::swap(other.x_t0, other.x_t1);
    const double reversed = time_of(other);
    EXPECT_EQ(reversed == kNoCollision, toi == kNoCollision) << hex_text(q);
    // The first contact of the reversed motion is the last one, seen from the end.
    if (toi != kNoCollision) {
      EXPECT_LE(toi + reversed, 1.0) << hex_text(q);
    }
  });
}

TEST(CcdExactSymmetry, TheTimeHalvesAtDoubleSpeed) {
  Random r(8);
  for (int i = 0; i < 16000; ++i) {
    const int family = i % ccd_queries::kIntegerFamilies;
    if (family == ccd_queries::kNudgedFamily) continue;
    Query q = families()[family].make(r, kind_of_index(integer(r, 0, 1)));
    const double toi = time_of(q);
    if (toi == kNoCollision) continue;
    // Integers: the doubled motion is exact, and so is half a double.
    for (int k = 0; k < 4; ++k) q.x_t1[k] = 2.0 * q.x_t1[k] - q.x_t0[k];
    ASSERT_EQ(time_of(q), 0.5 * toi) << hex_text(q);
  }
}

// ---------------------------------------------------------------------------------------------
// One behaviour each

TEST(CcdExact, TouchingAtTheLastInstantCountsAsAHit) {
  EXPECT_EQ(time_of(falling_point(1.0, 0.0)), 1.0);
  EXPECT_EQ(time_of(falling_point(1.0, std::numeric_limits<double>::denorm_min())), kNoCollision);
}

TEST(CcdExact, TouchingAtTheFirstInstantCountsAsAHit) {
  EXPECT_EQ(time_of(falling_point(0.0, 5.0)), 0.0);
}

TEST(CcdExact, ATimeThatIsNoDoubleIsRoundedDown) {
  EXPECT_EQ(time_of(falling_point(1.0, -2.0)), 1.0 / 3.0);                 // the double below 1/3
  EXPECT_EQ(time_of(falling_point(1.0, -4.0)), std::nextafter(0.2, 0.0));  // 0.2 is above 1/5
}

TEST(CcdExact, EveryStageIsUsedAndCounted) {
  const std::vector<Query> queries = mixed_queries(74, 40);
  std::vector<double> toi(queries.size());
  CcdExactStages stages;
  find_times_counting_stages(queries, toi, stages);
  EXPECT_GT(stages.separated, 0u);
  EXPECT_GT(stages.never_coplanar, 0u);
  EXPECT_GT(stages.isolated, 0u);
  EXPECT_GT(stages.exact, 0u);
  EXPECT_EQ(stages.separated + stages.never_coplanar + stages.isolated + stages.exact,
            queries.size());
}

TEST(CcdExact, AQueryThatIsNotFiniteIsRefusedWithTheVertex) {
  for (const double bad : {kInf, -kInf, std::numeric_limits<double>::quiet_NaN()}) {
    Query q = falling_point(1.0, 0.0);
    q.x_t1[2].y() = bad;
    try {
      time_of(q);
      FAIL() << "accepted " << bad;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find("vertex 2"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace selvedge::ccd_exact_test
