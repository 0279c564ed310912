// SPDX-License-Identifier: MIT
#pragma once

#include <gmpxx.h>

#include <utility>
#include <vector>

namespace selvedge::judging {

/// A polynomial with integer coefficients, the constant first and the last one not 0; 0 is empty.
using Polynomial = std::vector<mpz_class>;

Polynomial operator+(const Polynomial& a, const Polynomial& b);
Polynomial operator-(const Polynomial& a, const Polynomial& b);
Polynomial operator*(const Polynomial& a, const Polynomial& b);

/// The dyadic number numerator / 2^exponent.
struct DyadicTime {
  mpz_class numerator;
  unsigned exponent;
};

/// Sign of p at t.
int sign_at(const Polynomial& p, const DyadicTime& t);

/// Signs of the Bernstein coefficients of p on [k/2^m, (k+1)/2^m].
std::vector<int> bernstein_signs(const Polynomial& p, const mpz_class& k, unsigned m);

/// True if p, not 0, has no root in [0,1] by the signs of its Bernstein coefficients; false
/// promises nothing.
bool has_evidently_no_root(const Polynomial& p);

/// A real root in [0,1] of a polynomial: itself a dyadic number, or the only root of a square-free
/// polynomial in the open interval (k/2^m, (k+1)/2^m). Asking for signs narrows the interval.
class Root {
 public:
  explicit Root(DyadicTime t) : exact_(true), k_(std::move(t.numerator)), m_(t.exponent) {}
  Root(Polynomial square_free, mpz_class k, unsigned m);

  /// Sign of q at the root. Exact.
  int sign_of(const Polynomial& q);

 private:
  void narrow();
  bool is_root_of(const Polynomial& q) const;

  bool exact_ = false;
  Polynomial square_free_;
  mpz_class k_;
  unsigned m_ = 0;
  int left_sign_ = 0;  // of square_free_ just right of the interval's lower end
};

/// All distinct roots of p, not 0, in [0,1], in no particular order.
std::vector<Root> roots_in_unit_interval(const Polynomial& p);

}  // namespace selvedge::judging
