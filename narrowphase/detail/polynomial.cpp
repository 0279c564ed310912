// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/check.h>
#include <selvedge/narrowphase/detail/polynomial_box.h>
#include <selvedge/narrowphase/detail/polynomial_sign.h>

namespace selvedge::detail {

template <class Int>
bool Polynomial<Int>::is_zero() const {
  for (int i = 0; i <= degree; ++i)
    if (!c[i].is_zero()) return false;
  return true;
}

template <class Int>
Polynomial<Int> operator-(const Polynomial<Int>& a, const Polynomial<Int>& b) {
  Polynomial<Int> r;
  r.degree = a.degree;
  for (int i = 0; i <= a.degree; ++i) r.c[i] = a.c[i] - b.c[i];
  return r;
}

template <class Int>
Polynomial<Int> operator*(const Polynomial<Int>& a, const Polynomial<Int>& b) {
  Polynomial<Int> r;
  r.degree = a.degree + b.degree;
  add_product(r, a, b);
  return r;
}

template <class Int>
void add_product(Polynomial<Int>& r, const Polynomial<Int>& a, const Polynomial<Int>& b,
                 bool negate) {
  SELVEDGE_ASSERT(r.degree == a.degree + b.degree && r.degree <= Polynomial<Int>::kMaxDegree);
  for (int i = 0; i <= a.degree; ++i)
    for (int j = 0; j <= b.degree; ++j) r.c[i + j].add_product(a.c[i], b.c[j], negate);
}

template <class Int>
int sign_at(const Polynomial<Int>& p, const Int& k, int m) {
  if (k.is_zero()) return p.c[0].sign();
  const Int rest = power_of_two<Int>(m) - k;
  if (rest.is_zero()) return p.c[p.degree].sign();
  if (const int s = sign_if_certain(p, k, rest); s != 0) return s;
  // Homogeneous Horner scheme: sum of c[i] k^i rest^(n-i).
  Int value = p.c[p.degree];
  Int power(1);
  for (int i = p.degree; i-- > 0;) {
    power = power * rest;
    value = value * k;
    value.add_product(p.c[i], power);
  }
  return value.sign();
}

#define SELVEDGE_INSTANTIATE(Int)                                                             \
  template struct Polynomial<Int>;                                                            \
  template Polynomial<Int> operator-(const Polynomial<Int>&, const Polynomial<Int>&);         \
  template Polynomial<Int> operator*(const Polynomial<Int>&, const Polynomial<Int>&);         \
  template void add_product(Polynomial<Int>&, const Polynomial<Int>&, const Polynomial<Int>&, \
                            bool);                                                            \
  template int sign_at(const Polynomial<Int>&, const Int&, int);
SELVEDGE_INSTANTIATE(BigInt)
SELVEDGE_INSTANTIATE(SmallInt)
#undef SELVEDGE_INSTANTIATE

}  // namespace selvedge::detail
