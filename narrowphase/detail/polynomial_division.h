// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/detail/polynomial.h>

#include <algorithm>
#include <utility>

namespace selvedge::detail {

template <class Int>
void drop_leading_zeros(Polynomial<Int>& p) {
  while (p.degree > 0 && p.c[p.degree].is_zero()) --p.degree;
}

// Polynomials in u = t / (1 - t) with a nonzero leading coefficient, for division.

/// Divides by the largest power of two common to all coefficients.
template <class Int>
void drop_content(Polynomial<Int>& p) {
  int shift = std::numeric_limits<int>::max();
  for (int i = 0; i <= p.degree; ++i)
    if (!p.c[i].is_zero()) shift = std::min(shift, p.c[i].trailing_zeros());
  if (shift == 0 || shift == std::numeric_limits<int>::max()) return;
  for (int i = 0; i <= p.degree; ++i) p.c[i] = p.c[i] >> shift;
}

/// A positive multiple of a mod b in Q[u].
template <class Int>
Polynomial<Int> remainder(Polynomial<Int> a, const Polynomial<Int>& b) {
  drop_leading_zeros(a);
  const Int& lead = b.c[b.degree];
  const Int factor = lead.sign() < 0 ? -lead : lead;
  while (a.degree >= b.degree && !a.is_zero()) {
    const Int top = lead.sign() < 0 ? -a.c[a.degree] : a.c[a.degree];
    const int shift = a.degree - b.degree;
    for (int i = 0; i < a.degree; ++i) {
      a.c[i] = a.c[i] * factor;
      if (i >= shift) a.c[i].add_product(top, b.c[i - shift], true);
    }
    a.c[a.degree] = Int();
    if (a.degree == 0) break;
    drop_leading_zeros(a);
  }
  drop_content(a);
  return a;
}

template <class Int>
Polynomial<Int> derivative(const Polynomial<Int>& p) {
  Polynomial<Int> d;
  d.degree = std::max(p.degree - 1, 0);
  for (int i = 1; i <= p.degree; ++i) d.c[i - 1] = p.c[i] * Int(i);
  return d;
}

/// Counts sign changes in a sequence, ignoring zeros.
class SignChanges {
 public:
  void add(int sign) {
    if (sign == 0) return;
    if (last_ != 0 && sign != last_) ++count_;
    last_ = sign;
  }
  int count() const { return count_; }

 private:
  int last_ = 0, count_ = 0;
};

template <class Int>
int sign_changes(const Polynomial<Int>& p) {
  SignChanges changes;
  for (int i = 0; i <= p.degree; ++i) changes.add(p.c[i].sign());
  return changes.count();
}

}  // namespace selvedge::detail
