// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/detail/polynomial.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

// A polynomial on a part of [0, 1].

namespace selvedge::narrowphase_detail {

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

/// p restricted to the box, in the same form, times a power of two.
template <class Int>
Polynomial<Int> restrict_to(const Polynomial<Int>& p, const Box<Int>& box) {
  if (box.m == 0) return p;
  // With s the position in the box: 1 - t ~ a (1-s) + b s, t ~ c (1-s) + d s.
  const Int one = power_of_two<Int>(box.m), c = box.k, d = box.end(), a = one - c, b = one - d;
  Polynomial<Int> result, power;
  result.c[0] = p.c[p.degree];
  power.c[0] = Int(1);
  const auto times = [](const Polynomial<Int>& q, const Int& x, const Int& y) {
    Polynomial<Int> r;
    r.degree = q.degree + 1;
    for (int j = 0; j <= q.degree; ++j) {
      r.c[j].add_product(q.c[j], x);
      r.c[j + 1].add_product(q.c[j], y);
    }
    return r;
  };
  for (int i = p.degree; i-- > 0;) {
    result = times(result, c, d);
    power = times(power, a, b);
    for (int j = 0; j <= result.degree; ++j) result.c[j].add_product(power.c[j], p.c[i]);
  }
  return result;
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

}  // namespace selvedge::narrowphase_detail
