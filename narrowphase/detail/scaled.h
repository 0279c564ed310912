// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/internal/big_int.h>
#include <selvedge/narrowphase/detail/double_double.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace selvedge::detail {

/// value * 2^exponent, for numbers far beyond the range of doubles. 0 has the value 0.
struct Scaled {
  DoubleDouble value;
  long exponent = 0;
};

/// The leading 106 bits of an integer, with |value| in [0.5, 1): truncated, relative error below
/// 2^-104.
template <class Int>
Scaled scaled(const Int& a) {
  int exponent = 0, rest_exponent = 0;
  const double hi = a.mantissa(exponent);
  if (hi == 0.0) return {};
  const double rest = (a - Int::from_double(hi, -exponent)).mantissa(rest_exponent);
  return {fast_two_sum(hi, std::ldexp(rest, rest_exponent - exponent)), exponent};
}

inline Scaled scaled(const BigInt& a) {
  int exponent = 0;
  double rest = 0.0;
  const double hi = a.mantissa(exponent, rest);
  return {fast_two_sum(hi, rest), exponent};
}

/// Relative error: see double_double.h. Products of up to eight factors stay in the normal range.
inline Scaled operator*(const Scaled& a, const Scaled& b) {
  return {a.value * b.value, a.exponent + b.exponent};
}
inline Scaled operator*(double factor, const Scaled& a) {
  return {DoubleDouble{factor, 0.0} * a.value, a.exponent};
}

/// The sign of the sum of products of at most eight integers and a factor below 32 each, if it is
/// certain, else 0; 0 also for a sum that is zero.
///
/// Proof: the factors of a term have a relative error below 2^-104 each and the eight products 7 *
/// 2^-106 each, together less than 2^-99. The sums of at most six terms, the largest of which is
/// the unit 2^e, add less than 6 * 6 * 7 * 2^-106 of it, and terms that vanish less than 2^-200. As
/// |term| / 2^e is at most 32, all errors together are below 6 * 32 * 2^-99 + 2^-97 < 2^-91.
template <std::size_t kTerms>
int certain_sign(const std::array<Scaled, kTerms>& terms) {
  static_assert(kTerms <= 6);
  constexpr double kError = 0x1p-90;
  constexpr long kVanishes = 250;
  long unit = std::numeric_limits<long>::min();
  for (const Scaled& t : terms)
    if (t.value.hi != 0.0) unit = std::max(unit, t.exponent);
  DoubleDouble sum;
  for (const Scaled& t : terms) {
    if (t.value.hi == 0.0 || t.exponent < unit - kVanishes) continue;
    const int shift = static_cast<int>(t.exponent - unit);
    sum = sum + DoubleDouble{std::ldexp(t.value.hi, shift), std::ldexp(t.value.lo, shift)};
  }
  return sum.hi > kError ? 1 : (sum.hi < -kError ? -1 : 0);
}

}  // namespace selvedge::detail
