// SPDX-License-Identifier: MIT
// The elementary functions against the C library's in extended precision, at their stated bounds,
// and at the arguments for which the C standard prescribes the result.
#include <gtest/gtest.h>
#include <selvedge/core/base/internal/elementary.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>

namespace selvedge {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kDraws = 200000;

/// The unit in the last place of a double near y.
double ulp(long double y) {
  int exponent = 0;
  std::frexp(static_cast<double>(std::abs(y)), &exponent);
  return std::ldexp(1.0, std::max(exponent - 53, -1074));
}

double error(double value, long double exact) {
  return static_cast<double>(std::abs(static_cast<long double>(value) - exact)) / ulp(exact);
}

class Draws {
 public:
  double uniform(double a, double b) {
    return a + (b - a) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }
  /// Of any size between 2^a and 2^b, of both signs.
  double sized(double a, double b) {
    return std::copysign(std::exp2(uniform(a, b)), uniform(-1.0, 1.0));
  }

 private:
  std::mt19937_64 random_{7};
};

/// The largest error of `f` over the arguments that `draw` gives, ulp; expects it below `bound` and
/// above a fifth of it, so that the bound says something.
template <class F, class Exact, class Draw>
void expect_within(double bound, const char* name, F f, Exact exact, Draw draw) {
  double worst = 0.0, at = 0.0;
  Draws draws;
  for (int i = 0; i < kDraws; ++i) {
    const double x = draw(draws);
    const double e = error(f(x), exact(static_cast<long double>(x)));
    if (!(e <= worst)) worst = e, at = x;
  }
  EXPECT_LE(worst, bound) << name << " at " << at;
  EXPECT_GE(worst, 0.2 * bound) << name;
}

#define WITHIN(bound, f, draw)                              \
  expect_within(                                            \
      bound, #f, [](double x) { return elementary::f(x); }, \
      [](long double x) { return std::f(x); }, [](Draws& d) { return draw; })

TEST(Elementary, SinesAndTangentsKeepTheirBounds) {
  if (std::numeric_limits<long double>::digits < 64) GTEST_SKIP() << "no extended precision here";
  WITHIN(1.1, sin, d.uniform(-10.0, 10.0));
  WITHIN(1.1, cos, d.uniform(-10.0, 10.0));
  WITHIN(1.1, sin, d.sized(-60.0, 19.9));
  WITHIN(1.1, cos, d.sized(-60.0, 19.9));
  WITHIN(2.5, tan, d.uniform(-1.57, 1.57));
  // next to the multiples of π/2, where the reduction of the argument loses most
  const auto near_zero = [](Draws& d) {
    const double x = std::floor(d.uniform(0.0, 6e5)) * (0.5 * std::numbers::pi);
    return d.uniform(0.0, 1.0) < 0.5 ? x : std::nextafter(x, kInfinity);
  };
  expect_within(
      1.1, "sin", [](double x) { return elementary::sin(x); },
      [](long double x) { return std::sin(x); }, near_zero);
  expect_within(
      1.1, "cos", [](double x) { return elementary::cos(x); },
      [](long double x) { return std::cos(x); }, near_zero);
}

TEST(Elementary, AnglesKeepTheirBounds) {
  if (std::numeric_limits<long double>::digits < 64) GTEST_SKIP() << "no extended precision here";
  WITHIN(1.6, atan, d.uniform(-3.0, 3.0));
  WITHIN(1.6, atan, d.sized(-80.0, 80.0));
  WITHIN(3.0, asin, d.uniform(-1.0, 1.0));
  WITHIN(3.0, acos, d.uniform(-1.0, 1.0));
  WITHIN(3.0, acos, 1.0 - std::exp2(d.uniform(-50.0, 0.0)));
  Draws d;
  for (int i = 0; i < kDraws; ++i) {
    const bool wild = i % 2 == 0;
    const double y = wild ? d.sized(-1000.0, 1000.0) : d.uniform(-1.0, 1.0);
    const double x = wild ? d.sized(-1000.0, 1000.0) : d.uniform(-1.0, 1.0);
    const long double exact = std::atan2(static_cast<long double>(y), static_cast<long double>(x));
    ASSERT_LE(error(elementary::atan2(y, x), exact), 1.6) << y << " " << x;
  }
}

TEST(Elementary, ExponentialsLogarithmsAndRootsKeepTheirBounds) {
  if (std::numeric_limits<long double>::digits < 64) GTEST_SKIP() << "no extended precision here";
  WITHIN(1.0, exp, d.uniform(-30.0, 30.0));
  WITHIN(1.0, exp, d.uniform(-745.0, 709.7));
  WITHIN(1.0, log, d.uniform(1e-9, 3.0));
  WITHIN(1.0, log, std::exp2(d.uniform(-1074.0, 1023.9)));
  WITHIN(2.0, log1p, d.uniform(-0.9999, 3.0));
  WITHIN(2.0, log1p, std::exp2(d.uniform(-80.0, 60.0)));
  WITHIN(1.0, cbrt, d.sized(-1074.0, 1023.9));
  Draws d;
  for (int i = 0; i < kDraws; ++i) {
    const double x = d.sized(-1074.0, 1022.0), y = d.sized(-1074.0, 1022.0);
    const long double length = std::hypot(static_cast<long double>(x), static_cast<long double>(y));
    ASSERT_LE(error(elementary::hypot(x, y), length), 1.2) << x << " " << y;
    const double base = d.uniform(1e-6, 2.0), power = d.uniform(-3.0, 3.0);
    const long double exact =
        std::pow(static_cast<long double>(base), static_cast<long double>(power));
    ASSERT_LE(error(elementary::pow(base, power), exact),
              1.0 + 3.0 * std::abs(power * std::log(base)))
        << base << " " << power;
  }
}

TEST(Elementary, SpecialArgumentsGiveTheStandardsResults) {
  EXPECT_TRUE(std::isnan(elementary::sin(kInfinity)) && std::isnan(elementary::cos(kNaN)));
  EXPECT_TRUE(std::signbit(elementary::sin(-0.0)) && std::signbit(elementary::atan(-0.0)));
  EXPECT_EQ(elementary::sin_cos(0.0).cosine, 1.0);
  EXPECT_TRUE(std::isnan(elementary::asin(1.0000000000000002)));
  EXPECT_TRUE(std::isnan(elementary::acos(kNaN)));
  EXPECT_EQ(elementary::acos(1.0), 0.0);
  EXPECT_EQ(elementary::acos(-1.0), std::numbers::pi);
  for (const double y : {0.0, -0.0, 1.0, -1.0, kInfinity, -kInfinity, 5e-324})
    for (const double x : {0.0, -0.0, 1.0, -1.0, kInfinity, -kInfinity, 5e-324}) {
      const double own = elementary::atan2(y, x), standard = std::atan2(y, x);
      EXPECT_EQ(std::signbit(own), std::signbit(standard)) << y << " " << x;
      EXPECT_NEAR(own, standard, 1e-15) << y << " " << x;
    }
  EXPECT_EQ(elementary::exp(-kInfinity), 0.0);
  EXPECT_EQ(elementary::exp(1000.0), kInfinity);
  EXPECT_EQ(elementary::exp(0.0), 1.0);
  EXPECT_EQ(elementary::log(1.0), 0.0);
  EXPECT_EQ(elementary::log(0.0), -kInfinity);
  EXPECT_TRUE(std::isnan(elementary::log(-1.0)) && std::isnan(elementary::log1p(-2.0)));
  EXPECT_EQ(elementary::log1p(-1.0), -kInfinity);
  EXPECT_EQ(elementary::pow(0.0, -1.0), kInfinity);
  EXPECT_EQ(elementary::pow(3.0, 0.0), 1.0);
  EXPECT_EQ(elementary::cbrt(-27.0), -3.0);
  EXPECT_EQ(elementary::hypot(3.0, 4.0), 5.0);
  EXPECT_EQ(elementary::hypot(kNaN, -kInfinity), kInfinity);
}

// Bits that every compiler, processor and C library must give: an FNV hash over 10^5 results.
TEST(Elementary, ResultsHaveTheSameBitsEverywhere) {
  std::uint64_t hash = 14695981039346656037u, state = 1;
  const auto next = [&] {  // of a size between 2^-31 and 2^32
    state = state * 6364136223846793005u + 1442695040888963407u;
    const double mantissa = 1.0 + static_cast<double>(state >> 12) * 0x1p-52;
    return std::ldexp(mantissa, static_cast<int>(state % 64) - 31);
  };
  const auto add = [&](double value) {
    hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 1099511628211u;
  };
  for (int i = 0; i < 10000; ++i) {
    const double x = next(), y = next(), below = x / (x + y);
    add(elementary::sin(x));
    add(elementary::cos(x));
    add(elementary::tan(x));
    add(elementary::atan2(y, x));
    add(elementary::asin(below));
    add(elementary::acos(below));
    add(elementary::exp(below * 500.0 - 250.0));
    add(elementary::log(x));
    add(elementary::log1p(y));
    add(elementary::pow(x, below));
    add(elementary::cbrt(x));
    add(elementary::hypot(x, y));
  }
  EXPECT_EQ(hash, 10143079366755714952u);
}

}  // namespace
}  // namespace selvedge
