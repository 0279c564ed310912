// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/detail/polynomial.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

// A polynomial on a part of [0, 1].

namespace selvedge::detail {

/// Number of bits by which one guess of the root in doubles shrinks a box: few enough, relative to
/// the rounding of doubles, that exact signs nearly always confirm the guess.
inline constexpr int kGuessedBits = 40;

/// The coefficients times one power of two; the largest is about 1.
template <class Int>
void to_doubles(const Polynomial<Int>& p, std::array<double, Polynomial<Int>::kMaxDegree + 1>& c) {
  int top = 0;
  for (int i = 0; i <= p.degree; ++i) top = std::max(top, p.c[i].bit_length());
  for (int i = 0; i <= p.degree; ++i) {
    int e = 0;
    const double f = p.c[i].mantissa(e);
    c[i] = std::ldexp(f, e - top);
  }
}

template <class Int>
Int power_of_two(int m) {
  return Int(1) << m;
}

template <class Int>
Int magnitude(const Int& a) {
  return a.sign() < 0 ? -a : a;
}

/// The sum of c[i] (1 + sign t)^(n-i) t^i in powers of t: from the form of a Polynomial to powers
/// for sign = -1, and back for sign = 1, as t^i = ((1-t) + t)^(n-i) t^i.
template <class Int>
void change_basis(Polynomial<Int>& p, int sign) {
  for (int i = 1; i <= p.degree; ++i)
    for (int j = i; j > 0; --j) p.c[j] = sign > 0 ? p.c[j] + p.c[j - 1] : p.c[j] - p.c[j - 1];
}

/// p restricted to the box, in the same form, times 2^(m degree).
template <class Int>
Polynomial<Int> restrict_to(const Polynomial<Int>& p, const Box<Int>& box) {
  if (box.m == 0) return p;
  // In powers: 2^(m n) p((k + width s) / 2^m) is the sum of c[i] 2^(m (n-i)) (k + width s)^i.
  Polynomial<Int> r = p;
  change_basis(r, -1);
  const int n = r.degree;
  for (int i = 0; i < n; ++i) r.c[i] = r.c[i] << (box.m * (n - i));
  for (int i = 0; i < n; ++i)
    for (int j = n - 1; j >= i; --j) r.c[j].add_product(r.c[j + 1], box.k);
  Int power = box.width;
  for (int i = 1; i <= n; ++i) {
    r.c[i] = r.c[i] * power;
    if (i < n) power = power * box.width;
  }
  change_basis(r, 1);
  return r;
}

/// +1 or -1 if all coefficients have that strict sign, so that the sign holds on the closed box.
template <class Int>
int strict_sign(const Polynomial<Int>& p) {
  const int s = p.c[0].sign();
  for (int i = 1; i <= p.degree; ++i)
    if (p.c[i].sign() != s) return 0;
  return s;
}

template <class Int>
int first_sign(const Polynomial<Int>& p) {
  for (int i = 0; i <= p.degree; ++i)
    if (!p.c[i].is_zero()) return p.c[i].sign();
  return 0;
}

/// The part of the box, divided into 2^bits cells, from cell `from` to cell `to`.
template <class Int>
Box<Int> part_of(const Box<Int>& box, int bits, std::int64_t from, std::int64_t to) {
  return {(box.k << bits) + box.width * Int(from), box.width * Int(to - from), box.m + bits};
}

}  // namespace selvedge::detail
