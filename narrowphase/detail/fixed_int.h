// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace selvedge::detail {

/// Thrown when a number does not fit into a FixedInt: repeat the computation with a wider type.
struct DoesNotFit {};

/// Signed integer of kLimbs * 64 bits in two's complement, with the operations of BigInt. No
/// operation loses bits: one whose result does not fit throws DoesNotFit.
template <int kLimbs>
class FixedInt {
 public:
  FixedInt() : limb_{} {}
  explicit FixedInt(std::int64_t value) {
    limb_.fill(value < 0 ? ~Limb{0} : Limb{0});
    limb_[0] = static_cast<Limb>(value);
  }

  /// The double times 2^-exponent; the caller guarantees that this is an integer.
  static FixedInt from_double(double value, int exponent) {
    if (value == 0.0) return FixedInt();
    constexpr int kMantissaBits = 53;
    int e = 0;
    const double m = std::frexp(value, &e);
    FixedInt r(static_cast<std::int64_t>(std::ldexp(m, kMantissaBits)));
    const int shift = e - kMantissaBits - exponent;
    return shift >= 0 ? r << shift : r >> -shift;
  }

  int sign() const { return is_negative() ? -1 : (is_zero() ? 0 : 1); }
  bool is_zero() const {
    Limb any = 0;
    for (const Limb l : limb_) any |= l;
    return any == 0;
  }
  bool is_odd() const { return (limb_[0] & 1U) != 0; }

  /// Position after the highest set bit of the magnitude; 0 for 0.
  int bit_length() const {
    const FixedInt m = magnitude();
    for (int i = kLimbs; i-- > 0;)
      if (m.limb_[i] != 0) return 64 * (i + 1) - std::countl_zero(m.limb_[i]);
    return 0;
  }
  /// Number of trailing zero bits; 0 for 0.
  int trailing_zeros() const {
    for (int i = 0; i < kLimbs; ++i)
      if (limb_[i] != 0) return 64 * i + std::countr_zero(limb_[i]);
    return 0;
  }
  /// Mantissa in [0.5, 1) with the sign, such that the number is about mantissa * 2^exponent;
  /// truncated, relative error below 2^-52.
  double mantissa(int& exponent) const {
    exponent = bit_length();
    if (exponent == 0) return 0.0;
    constexpr int kKept = 53;
    const FixedInt m = magnitude();
    const Limb top =
        exponent > kKept ? (m >> (exponent - kKept)).limb_[0] : m.limb_[0] << (kKept - exponent);
    const double f = static_cast<double>(top) * 0x1p-53;
    return is_negative() ? -f : f;
  }

  FixedInt operator-() const {
    FixedInt r;
    return r - *this;
  }
  FixedInt operator+(const FixedInt& b) const {
    FixedInt r;
    bool carry = false;
    for (int i = 0; i < kLimbs; ++i) r.limb_[i] = add_carry(limb_[i], b.limb_[i], carry);
    // Overflow: both operands have one sign and the result the other.
    check(((top() ^ r.top()) & (b.top() ^ r.top())) >> 63 == 0);
    return r;
  }
  FixedInt operator-(const FixedInt& b) const {
    FixedInt r;
    bool borrow = false;
    for (int i = 0; i < kLimbs; ++i) r.limb_[i] = subtract_borrow(limb_[i], b.limb_[i], borrow);
    check(((top() ^ b.top()) & (top() ^ r.top())) >> 63 == 0);
    return r;
  }
  FixedInt operator*(const FixedInt& b) const {
    const int na = used(), nb = b.used();
    if (na == 1 && nb == 1) return from_wide(wide(limb_[0]) * wide(b.limb_[0]));
    return product(b, na, nb);
  }
  /// *this += a * b, or -= if `negate`.
  void add_product(const FixedInt& a, const FixedInt& b, bool negate = false) {
    const int na = a.used(), nb = b.used();
    if (na == 1 && nb == 1) {
      const SignedDoubleLimb p = wide(a.limb_[0]) * wide(b.limb_[0]);
      return add_wide(negate ? -p : p);
    }
    const FixedInt p = a.product(b, na, nb);
    *this = negate ? *this - p : *this + p;
  }
  FixedInt operator<<(int bits) const {
    if (bits == 0) return *this;
    // The bits shifted out, and the new sign bit, must all equal the sign.
    check(bits < 64 * kLimbs - 1 && (is_zero() || bit_length() + bits < 64 * kLimbs));
    const int words = bits / 64, rest = bits % 64;
    FixedInt r;
    for (int i = kLimbs; i-- > words;) {
      r.limb_[i] = limb_[i - words] << rest;
      if (rest != 0 && i > words) r.limb_[i] |= limb_[i - words - 1] >> (64 - rest);
    }
    return r;
  }
  /// Shift of the magnitude, rounding towards zero.
  FixedInt operator>>(int bits) const {
    if (bits >= 64 * kLimbs) return FixedInt();
    const FixedInt m = magnitude();
    const int words = bits / 64, rest = bits % 64;
    FixedInt r;
    for (int i = 0; i + words < kLimbs; ++i) {
      r.limb_[i] = m.limb_[i + words] >> rest;
      if (rest != 0 && i + words + 1 < kLimbs) r.limb_[i] |= m.limb_[i + words + 1] << (64 - rest);
    }
    return is_negative() ? -r : r;
  }

 private:
  using Limb = std::uint64_t;
  __extension__ typedef unsigned __int128 DoubleLimb;
  __extension__ typedef __int128 SignedDoubleLimb;

  static FixedInt from_wide(SignedDoubleLimb value) {
    FixedInt r(static_cast<std::int64_t>(value >> 127));
    r.limb_[0] = static_cast<Limb>(value);
    r.limb_[1] = static_cast<Limb>(value >> 64);
    return r;
  }

  static Limb add_carry(Limb a, Limb b, bool& carry) {
    Limb sum = 0, result = 0;
    const bool first = __builtin_add_overflow(a, b, &sum);
    carry = first | __builtin_add_overflow(sum, Limb{carry}, &result);
    return result;
  }
  static Limb subtract_borrow(Limb a, Limb b, bool& borrow) {
    Limb difference = 0, result = 0;
    const bool first = __builtin_sub_overflow(a, b, &difference);
    borrow = first | __builtin_sub_overflow(difference, Limb{borrow}, &result);
    return result;
  }
  void add_wide(SignedDoubleLimb value) {
    const Limb filler = static_cast<Limb>(value >> 127), before = top();
    bool carry = false;
    limb_[0] = add_carry(limb_[0], static_cast<Limb>(value), carry);
    limb_[1] = add_carry(limb_[1], static_cast<Limb>(value >> 64), carry);
    for (int i = 2; i < kLimbs; ++i) limb_[i] = add_carry(limb_[i], filler, carry);
    check(((before ^ top()) & (filler ^ top())) >> 63 == 0);
  }

  static void check(bool fits) {
    if (!fits) [[unlikely]]
      throw DoesNotFit();
  }
  static SignedDoubleLimb wide(Limb l) { return static_cast<std::int64_t>(l); }
  Limb top() const { return limb_[kLimbs - 1]; }
  bool is_negative() const { return static_cast<std::int64_t>(top()) < 0; }
  FixedInt magnitude() const { return is_negative() ? -*this : *this; }

  /// Number of low limbs that, sign-extended, represent the number.
  int used() const {
    const Limb filler = is_negative() ? ~Limb{0} : Limb{0};
    int n = kLimbs;
    while (n > 1 && limb_[n - 1] == filler && (limb_[n - 2] ^ filler) >> 63 == 0) --n;
    return n;
  }

  /// Schoolbook multiplication of the limbs as stored. A negative factor of n limbs is stored as
  /// itself plus 2^(64 n), so the other factor, shifted by n limbs, is subtracted.
  FixedInt product(const FixedInt& b, int na, int nb) const {
    Limb p[2 * kLimbs] = {};
    for (int i = 0; i < na; ++i) {
      Limb carry = 0;
      for (int j = 0; j < nb; ++j) {
        const DoubleLimb s = DoubleLimb{limb_[i]} * b.limb_[j] + p[i + j] + carry;
        p[i + j] = static_cast<Limb>(s);
        carry = static_cast<Limb>(s >> 64);
      }
      p[i + nb] = carry;
    }
    if (is_negative()) take_away(p + na, b, nb);
    if (b.is_negative()) take_away(p + nb, *this, na);
    const int n = na + nb;
    const Limb filler = static_cast<std::int64_t>(p[n - 1]) < 0 ? ~Limb{0} : Limb{0};
    FixedInt r;
    for (int i = 0; i < kLimbs; ++i) r.limb_[i] = i < n ? p[i] : filler;
    for (int i = kLimbs; i < n; ++i) check(p[i] == filler);
    check(((r.top() ^ filler) >> 63) == 0);
    return r;
  }
  static void take_away(Limb* p, const FixedInt& b, int n) {
    Limb borrow = 0;
    for (int j = 0; j < n; ++j) {
      const DoubleLimb d = DoubleLimb{p[j]} - b.limb_[j] - borrow;
      p[j] = static_cast<Limb>(d);
      borrow = static_cast<Limb>(d >> 64) & 1U;
    }
  }

  std::array<Limb, kLimbs> limb_;
};

/// Wide enough for queries whose single-precision coordinates have similar magnitudes.
using SmallInt = FixedInt<6>;

}  // namespace selvedge::detail
