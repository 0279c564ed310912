// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/detail/polynomial.h>
#include <selvedge/narrowphase/detail/scaled.h>

#include <algorithm>
#include <array>

// Signs of polynomials, which 106 bits nearly always show.

namespace selvedge::detail {

/// The sign of the sum of c[i] num^i den^(n-i) if 106 bits show it, else 0. For short numbers the
/// exact sum is as quick.
template <class Int>
int sign_if_certain(const Polynomial<Int>& p, const Int& num, const Int& den) {
  constexpr int kLong = 512;  // bits
  if (p.c[0].bit_length() + p.degree * std::max(num.bit_length(), den.bit_length()) < kLong)
    return 0;
  const Scaled x = scaled(num), y = scaled(den);
  std::array<Scaled, Polynomial<Int>::kMaxDegree + 1> terms;
  Scaled power{{1.0, 0.0}, 0};
  for (int i = 0; i <= p.degree; ++i, power = power * x) terms[i] = scaled(p.c[i]) * power;
  power = {{1.0, 0.0}, 0};
  for (int i = p.degree; i >= 0; --i, power = power * y) terms[i] = terms[i] * power;
  return certain_sign(terms);
}

/// The sign of c1² - 4 c0 c2.
template <class Int>
int discriminant_sign(const Polynomial<Int>& q) {
  const Scaled a = scaled(q.c[2]), b = scaled(q.c[1]), c = scaled(q.c[0]);
  if (const int s = certain_sign(std::array{b * b, -4.0 * (a * c)}); s != 0) return s;
  Int exact = q.c[1] * q.c[1];
  exact.add_product(q.c[0] << 2, q.c[2], true);
  return exact.sign();
}

}  // namespace selvedge::detail
