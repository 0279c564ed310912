// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/detail/exact_query.h>
#include <selvedge/narrowphase/detail/rational.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <vector>

namespace selvedge::detail {
namespace {

using Limb = std::uint64_t;
__extension__ typedef unsigned __int128 DoubleLimb;

constexpr int kMantissaBits = std::numeric_limits<double>::digits;  // 53
constexpr int kMaxExponent = std::numeric_limits<double>::max_exponent;
constexpr int kLowestBit = std::numeric_limits<double>::min_exponent - kMantissaBits;  // -1074

/// Number of decimal digits that always fit into a limb.
constexpr std::size_t kLimbDigits = 19;

/// limbs = limbs * factor + addend.
void multiply_add(std::vector<Limb>& limbs, Limb factor, Limb addend) {
  for (Limb& limb : limbs) {
    const DoubleLimb p = DoubleLimb{limb} * factor + addend;
    limb = static_cast<Limb>(p);
    addend = static_cast<Limb>(p >> 64);
  }
  if (addend != 0) limbs.push_back(addend);
}

/// A magnitude as odd * 2^twos, little endian without leading zero limbs; empty for 0.
struct Magnitude {
  std::vector<Limb> odd;
  std::int64_t twos = 0;
};

void make_odd(Magnitude& m) {
  const auto first = std::find_if(m.odd.begin(), m.odd.end(), [](Limb l) { return l != 0; });
  m.twos = 64 * (first - m.odd.begin());
  m.odd.erase(m.odd.begin(), first);
  if (m.odd.empty()) return;
  const int shift = std::countr_zero(m.odd.front());
  m.twos += shift;
  if (shift == 0) return;
  for (std::size_t i = 0; i < m.odd.size(); ++i) {
    const Limb above = i + 1 < m.odd.size() ? m.odd[i + 1] : 0;
    m.odd[i] = m.odd[i] >> shift | above << (64 - shift);
  }
  if (m.odd.back() == 0) m.odd.pop_back();
}

/// A part of a rational number as written in the text.
struct Part {
  bool negative = false;
  std::string_view digits;
};

bool split_sign(std::string_view text, Part& part) {
  part.negative = !text.empty() && text[0] == '-';
  if (part.negative || (!text.empty() && text[0] == '+')) text.remove_prefix(1);
  part.digits = text;
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

Limb limb_of(std::string_view digits) {
  Limb limb = 0;
  for (const char c : digits) limb = 10 * limb + static_cast<Limb>(c - '0');
  return limb;
}

Magnitude magnitude_of(std::string_view digits) {
  Magnitude m;
  while (!digits.empty()) {
    const std::string_view chunk = digits.substr(0, kLimbDigits);
    Limb power = 1;
    for (std::size_t i = 0; i < chunk.size(); ++i) power *= 10;
    multiply_add(m.odd, power, limb_of(chunk));
    digits.remove_prefix(chunk.size());
  }
  make_odd(m);
  return m;
}

/// Computes value = q * 2^exponent for an odd q; returns false if that is not a double.
bool compose(Limb q, std::int64_t exponent, double& value) {
  const int bits = std::bit_width(q);
  if (bits > kMantissaBits || exponent < kLowestBit || exponent + bits > kMaxExponent) return false;
  value = std::ldexp(static_cast<double>(q), static_cast<int>(exponent));
  return true;
}

/// The inverse of an odd number modulo 2^64 by Newton's iteration: a step doubles the number k of
/// bits in x d = 1 mod 2^k. An odd number is its own inverse modulo 8.
Limb inverse(Limb d) {
  Limb x = d;
  for (int correct = 3; correct < 64; correct *= 2) x *= 2 - d * x;
  return x;
}

/// If num / den is a double, its odd part q = num.odd / den.odd is an integer below 2^53 and equals
/// num.odd times the inverse of den.odd modulo 2^64. The full product den.odd * q verifies this.
bool divide(const Magnitude& num, const Magnitude& den, double& value) {
  const Limb q = num.odd.front() * inverse(den.odd.front());
  if (std::bit_width(q) > kMantissaBits) return false;
  std::vector<Limb> product = den.odd;
  multiply_add(product, q, 0);
  return product == num.odd && compose(q, num.twos - den.twos, value);
}

/// The same if both parts fit into a limb.
bool divide_short(Limb num, Limb den, double& value) {
  const int num_twos = std::countr_zero(num), den_twos = std::countr_zero(den);
  num >>= num_twos;
  den >>= den_twos;
  return num % den == 0 && compose(num / den, num_twos - den_twos, value);
}

bool is_zero(std::string_view digits) {
  return digits.find_first_not_of('0') == std::string_view::npos;
}

bool divide_digits(std::string_view num, std::string_view den, double& value) {
  if (num.size() <= kLimbDigits && den.size() <= kLimbDigits)
    return divide_short(limb_of(num), limb_of(den), value);
  return divide(magnitude_of(num), magnitude_of(den), value);
}

/// Appends the decimal digits of 2^exponent, exponent >= 0.
void append_power_of_two(int exponent, std::string& text) {
  constexpr Limb kBase = 1'000'000'000'000'000'000;  // 10^18: its double fits in a limb
  constexpr int kBaseDigits = 18, kStep = 4;         // 2^4 kBase fits in a limb
  std::vector<Limb> parts{1};
  for (int done = 0; done < exponent;) {
    const int step = std::min(kStep, exponent - done);
    Limb carry = 0;
    for (Limb& part : parts) {
      const Limb shifted = (part << step) + carry;
      carry = shifted / kBase;
      part = shifted % kBase;
    }
    if (carry != 0) parts.push_back(carry);
    done += step;
  }
  text += std::to_string(parts.back());
  for (std::size_t i = parts.size() - 1; i-- > 0;) {
    const std::string digits = std::to_string(parts[i]);
    text.append(kBaseDigits - digits.size(), '0');
    text += digits;
  }
}

/// 2^0 to 2^1074 in decimal: the possible denominators of a double.
const std::string& power_of_two(int exponent) {
  static const std::vector<std::string> powers = [] {
    std::vector<std::string> all(-kLowestBit + 1);
    for (int e = 0; e <= -kLowestBit; ++e) append_power_of_two(e, all[e]);
    return all;
  }();
  return powers[exponent];
}

}  // namespace

RationalFault parse_rational(std::string_view num, std::string_view den, double& value) {
  Part n, d;
  if (!split_sign(num, n)) return RationalFault::numerator;
  if (!split_sign(den, d)) return RationalFault::denominator;
  if (n.digits.size() > kMaxDigits || d.digits.size() > kMaxDigits) return RationalFault::too_long;
  if (is_zero(d.digits)) return RationalFault::zero_denominator;
  value = 0.0;
  if (!is_zero(n.digits) && !divide_digits(n.digits, d.digits, value))
    return RationalFault::no_double;
  if (n.negative != d.negative) value = -value;
  return RationalFault::none;
}

void append_rational(double value, std::string& text) {
  const int below = value == 0.0 ? 0 : std::max(0, -lowest_bit(value));
  const double num = std::ldexp(value, below);  // an integer: exact
  constexpr std::size_t kLongest = 1 + std::numeric_limits<double>::max_exponent10 + 2;
  char digits[kLongest];  // holds every integer that is a double
  std::snprintf(digits, kLongest, "%.0f", num);
  text += digits;
  text += ',';
  text += power_of_two(below);
}

}  // namespace selvedge::detail
