// SPDX-License-Identifier: MIT
// The series are those of Taylor; their coefficients are exact fractions, rounded once. Where the
// reduced argument r has a known rounding error, the term c that it leaves is added to the small
// part of the result, so that the last rounding alone decides.

#include <selvedge/core/base/internal/elementary.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace selvedge::elementary {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Σ coefficients[k] x^k.
template <std::size_t N>
double series(const std::array<double, N>& coefficients, double x) {
  double sum = coefficients[N - 1];
  for (std::size_t k = N - 1; k-- > 0;) sum = sum * x + coefficients[k];
  return sum;
}

// --- sine and cosine
// ------------------------------------------------------------------------------

/// π/2 as a sum of three numbers: the first two have 33 bits, so that their products with a count
/// below 2^20 are exact.
constexpr double kHalfPi1 = 0x1.921fb544p+0, kHalfPi2 = 0x1.0b4611a6p-34,
                 kHalfPi3 = 0x1.3198a2e037073p-69;
constexpr double kLargestCounted = 0x1p20;

/// (sin r - r)/r³ and (cos r - 1 + r²/2)/r⁴ as series in r², for |r| <= π/4.
constexpr std::array kSine{
    -1.0 / 6,        1.0 / 120,        -1.0 / 5040,          1.0 / 362880,
    -1.0 / 39916800, 1.0 / 6227020800, -1.0 / 1307674368000, 1.0 / 355687428096000};
constexpr std::array kCosine{
    1.0 / 24,        -1.0 / 720,         1.0 / 40320,          -1.0 / 3628800,
    1.0 / 479001600, -1.0 / 87178291200, 1.0 / 20922789888000, -1.0 / 6402373705728000};

struct Reduced {
  double r = 0.0, c = 0.0;  ///< x = count π/2 + r + c with |r| <= π/4
  int quadrant = 0;         ///< count modulo 4
};

Reduced reduce(double x) {
  if (std::abs(x) > kLargestCounted) x = std::remainder(x, 2.0 * std::numbers::pi);
  const double count = std::nearbyint(x * (2.0 / std::numbers::pi));
  if (count == 0.0) return {x, 0.0, 0};
  // x - count kHalfPi1 is exact: both are near each other and multiples of a common small unit.
  const double first = x - count * kHalfPi1, middle = count * kHalfPi2;
  const double rest = first - middle, back = rest + middle;
  const double lost = (first - back) - (middle - (back - rest));  // exact: first - middle - rest
  const double small = lost - count * kHalfPi3;
  const double r = rest + small;
  return {r, (rest - r) + small, static_cast<int>(count) & 3};  // |count| < 2^20
}

double sine_of(double r, double c) {
  const double z = r * r;
  return r + (z * r * series(kSine, z) + c * (1.0 - 0.5 * z));
}

double cosine_of(double r, double c) {
  const double z = r * r, half = 0.5 * z, top = 1.0 - half;
  return top + (((1.0 - top) - half) + (z * z * series(kCosine, z) - r * c));
}

// --- arc tangent
// ----------------------------------------------------------------------------------

/// atan(k/8) for k = 0...8, as the nearest double and what it lacks.
struct Knot {
  double high, low;
};
constexpr std::array<Knot, 9> kKnots{{{0.0, 0.0},
                                      {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
                                      {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
                                      {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
                                      {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
                                      {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
                                      {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
                                      {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
                                      {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55}}};
constexpr double kPiLow = 0x1.1a62633145c07p-53;  ///< π = std::numbers::pi + kPiLow
constexpr std::array kArcTangent{-1.0 / 3, 1.0 / 5, -1.0 / 7, 1.0 / 9, -1.0 / 11, 1.0 / 13};

struct Sum {
  double high = 0.0, low = 0.0;
};

/// atan(num/den) for 0 <= num <= den, den > 0 finite, as a sum.
Sum angle_below_one(double num, double den) {
  const double k = std::nearbyint(8.0 * (num / den)), tangent = 0.125 * k;
  // atan(num/den) = atan(tangent) + atan(t)
  const double t = k == 0.0 ? num / den : (num - tangent * den) / (den + tangent * num);
  const double z = t * t, tail = t * z * series(kArcTangent, z);
  const Knot& knot = kKnots[static_cast<std::size_t>(k)];
  if (k == 0.0) return {t, tail};
  const double high = knot.high + t;  // |t| < knot.high
  return {high, ((knot.high - high) + t) + (knot.low + tail)};
}

/// a - b for a >= |b.high|.
Sum minus(double a, double a_low, const Sum& b) {
  const double high = a - b.high;
  return {high, ((a - high) - b.high) + (a_low - b.low)};
}

// --- exponential and logarithm
// ----------------------------------------------------------------------

/// ln 2 as a sum; the first part has 32 bits, so that its products with exponents are exact.
constexpr double kLn2 = 0x1.62e42feep-1, kLn2Low = 0x1.a39ef35793c76p-33;
constexpr std::array kExponential{1.0 / 2,       1.0 / 6,        1.0 / 24,        1.0 / 120,
                                  1.0 / 720,     1.0 / 5040,     1.0 / 40320,     1.0 / 362880,
                                  1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800};
/// 2 (artanh(s) - s)/s³ as a series in s².
constexpr std::array kLogarithm{2.0 / 3,  2.0 / 5,  2.0 / 7,  2.0 / 9,  2.0 / 11,
                                2.0 / 13, 2.0 / 15, 2.0 / 17, 2.0 / 19, 2.0 / 21};

/// exponent·ln 2 + log(1 + f) + c for sqrt(1/2) <= 1 + f <= sqrt(2). With s = f/(2 + f),
/// log(1 + f) = 2 artanh(s) = f - (f²/2 - s (f²/2 + R)), where R is what follows 2s in the series,
/// divided by s.
double log_of(double f, double exponent, double c) {
  const double s = f / (2.0 + f), z = s * s, half = 0.5 * f * f;
  const double small = s * (half + z * series(kLogarithm, z)) + (exponent * kLn2Low + c);
  return exponent * kLn2 + (f - (half - small));
}

}  // namespace

SineCosine sin_cos(double x) {
  if (!std::isfinite(x)) return {kNaN, kNaN};
  if (std::abs(x) < 0x1p-28) return {x, 1.0};  // keeps the sign of a zero
  const Reduced a = reduce(x);
  const double s = sine_of(a.r, a.c), c = cosine_of(a.r, a.c);
  switch (a.quadrant) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

double sin(double x) { return sin_cos(x).sine; }
double cos(double x) { return sin_cos(x).cosine; }

double tan(double x) {
  const SineCosine a = sin_cos(x);
  return a.sine / a.cosine;
}

double atan(double x) { return atan2(x, 1.0); }

double atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return kNaN;
  double rise = std::abs(y), run = std::abs(x);
  if (std::isinf(rise) || std::isinf(run)) {
    // Infinite coordinates are equal to each other and beyond all others.
    rise = std::isinf(rise) ? 1.0 : 0.0;
    run = std::isinf(run) ? 1.0 : 0.0;
  }
  const bool steep = rise > run;
  double num = steep ? run : rise, den = steep ? rise : run;
  if (den == 0.0) den = 1.0;  // the origin: 0 or π, by the sign of x
  if (den > 0x1p1000) {
    num *= 0x1p-100;
    den *= 0x1p-100;
  } else if (den < 0x1p-900) {
    num *= 0x1p100;
    den *= 0x1p100;
  }
  Sum angle = angle_below_one(num, den);
  if (steep) angle = minus(0.5 * std::numbers::pi, 0.5 * kPiLow, angle);
  if (std::signbit(x)) angle = minus(std::numbers::pi, kPiLow, angle);
  return std::copysign(angle.high + angle.low, y);
}

double asin(double x) {
  if (!(std::abs(x) <= 1.0)) return kNaN;
  return atan2(x, std::sqrt((1.0 - x) * (1.0 + x)));
}

double acos(double x) {
  if (!(std::abs(x) <= 1.0)) return kNaN;
  return atan2(std::sqrt((1.0 - x) * (1.0 + x)), x);
}

double exp(double x) {
  if (std::isnan(x)) return x;
  if (x > 710.0) return kInfinity;
  if (x < -746.0) return 0.0;
  const double count = std::nearbyint(x * std::numbers::log2e);
  const double high = x - count * kLn2, low = count * kLn2Low;
  const double r = high - low, c = (high - r) - low;
  return std::ldexp(1.0 + (r + (r * r * series(kExponential, r) + c)), static_cast<int>(count));
}

double log(double x) {
  if (std::isnan(x) || x < 0.0) return kNaN;
  if (x == 0.0) return -kInfinity;
  if (std::isinf(x)) return x;
  int exponent = 0;
  double mantissa = std::frexp(x, &exponent);
  if (mantissa < 0.5 * std::numbers::sqrt2) {
    mantissa *= 2.0;
    --exponent;
  }
  return log_of(mantissa - 1.0, exponent, 0.0);
}

double log1p(double x) {
  if (std::isnan(x) || x < -1.0) return kNaN;
  if (x == -1.0) return -kInfinity;
  if (std::isinf(x) || x == 0.0) return x;
  if (x > -0.29 && x < 0.41) return log_of(x, 0.0, 0.0);
  const double sum = 1.0 + x, lost = x > 1.0 ? 1.0 - (sum - x) : x - (sum - 1.0);
  return log(sum) + lost / sum;
}

double pow(double base, double exponent) {
  if (exponent == 0.0 || base == 1.0) return 1.0;
  if (base < 0.0) return kNaN;
  if (base == 0.0) return exponent > 0.0 ? 0.0 : kInfinity;
  return exp(exponent * log(base));
}

double cbrt(double x) {
  if (!std::isfinite(x) || x == 0.0) return x;
  int exponent = 0;
  const double mantissa = std::frexp(std::abs(x), &exponent);
  int third = exponent / 3;
  if (exponent - 3 * third < 0) --third;
  const double a = std::ldexp(mantissa, exponent - 3 * third);  // in [0.5, 4)
  double root = exp(log(a) / 3.0);
  root -= (root * root * root - a) / (3.0 * root * root);  // one step of Newton
  return std::copysign(std::ldexp(root, third), x);
}

double hypot(double x, double y) {
  x = std::abs(x);
  y = std::abs(y);
  if (std::isinf(x) || std::isinf(y)) return kInfinity;
  if (std::isnan(x) || std::isnan(y)) return kNaN;
  const double most = std::max(x, y);
  const double unit = most > 0x1p500 ? 0x1p600 : most < 0x1p-400 ? 0x1p-600 : 1.0;
  x /= unit;
  y /= unit;
  return std::sqrt(x * x + y * y) * unit;
}

}  // namespace selvedge::elementary
