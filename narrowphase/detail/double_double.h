// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <array>

// Sums and products of double-doubles are off by at most 7 * 2^-106 of the result
// [JoldesMullerPopescu2017] algorithms 6 and 10.

namespace selvedge::detail {

/// hi + lo with |lo| at most half an ulp of hi: 106 bits.
struct DoubleDouble {
  double hi = 0.0, lo = 0.0;
};

/// a + b exactly [Knuth 1969].
inline DoubleDouble two_sum(double a, double b) {
  const double s = a + b, t = s - a;
  return {s, (a - (s - t)) + (b - t)};
}

/// a + b exactly for |a| >= |b| [Dekker 1971].
inline DoubleDouble fast_two_sum(double a, double b) {
  const double s = a + b;
  return {s, b - (s - a)};
}

/// a * b exactly by splitting both into halves [Dekker 1971].
inline DoubleDouble two_product(double a, double b) {
  constexpr double kSplitter = 0x1p27 + 1.0;
  const double ca = kSplitter * a, cb = kSplitter * b;
  const double ah = ca - (ca - a), bh = cb - (cb - b);
  const double al = a - ah, bl = b - bh, p = a * b;
  return {p, ((ah * bh - p) + ah * bl + al * bh) + al * bl};
}

inline DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble s = two_sum(a.hi, b.hi), t = two_sum(a.lo, b.lo);
  const DoubleDouble v = fast_two_sum(s.hi, s.lo + t.hi);
  return fast_two_sum(v.hi, t.lo + v.lo);
}

inline DoubleDouble operator-(const DoubleDouble& a) { return {-a.hi, -a.lo}; }
inline DoubleDouble operator-(const DoubleDouble& a, const DoubleDouble& b) { return a + -b; }

inline DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble p = two_product(a.hi, b.hi);
  return fast_two_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

/// A vector in double-double.
using SharpVec = std::array<DoubleDouble, 3>;

inline SharpVec cross(const SharpVec& a, const SharpVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline SharpVec operator+(const SharpVec& a, const SharpVec& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

inline DoubleDouble dot(const SharpVec& a, const SharpVec& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline SharpVec difference(const Vec3& a, const Vec3& b) {
  return {two_sum(a[0], -b[0]), two_sum(a[1], -b[1]), two_sum(a[2], -b[2])};
}

}  // namespace selvedge::detail
