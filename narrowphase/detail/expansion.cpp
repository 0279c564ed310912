// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/detail/expansion.h>

#include <cmath>
#include <cstddef>

namespace selvedge::detail {
namespace {

/// a + b = sum + error, exactly. [Shewchuk1997] theorem 7.
void two_sum(double a, double b, double& sum, double& error) {
  sum = a + b;
  const double b_virtual = sum - a, a_virtual = sum - b_virtual;
  error = (a - a_virtual) + (b - b_virtual);
}

}  // namespace

Expansion::Expansion(double head, double tail) {
  add(head);
  add(-tail);
}

void Expansion::add(double x) {
  std::size_t kept = 0;
  for (const double term : terms_) {
    double error = 0.0;
    two_sum(x, term, x, error);
    if (error != 0.0) terms_[kept++] = error;
  }
  terms_.resize(kept);
  if (x != 0.0) terms_.push_back(x);
}

Expansion operator+(Expansion a, const Expansion& b) {
  for (const double term : b.terms_) a.add(term);
  return a;
}

Expansion operator-(Expansion a, const Expansion& b) {
  for (const double term : b.terms_) a.add(-term);
  return a;
}

Expansion operator*(const Expansion& a, const Expansion& b) {
  Expansion product;
  for (const double x : a.terms_) {
    for (const double y : b.terms_) {
      const double p = x * y;
      product.add(std::fma(x, y, -p));
      product.add(p);
    }
  }
  return product;
}

}  // namespace selvedge::detail
