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

/// A real number in [0,1] between neighbouring doubles; lo == hi exactly if it is a double itself.
struct TimeEnclosure {
  double lo, hi;
};

/// A real root in [0,1] of a polynomial: itself a dyadic number, or the only root, a simple one, of
/// a polynomial in the open interval (k/2^m, (k+1)/2^m). Asking for signs narrows the interval.
class Root {
 public:
  explicit Root(DyadicTime t) : exact_(true), k_(std::move(t.numerator)), m_(t.exponent) {}
  Root(Polynomial p, mpz_class k, unsigned m);

  /// Sign of q at the root. Exact.
  int sign_of(const Polynomial& q);
  /// lo is the largest double not above the root, hi the smallest one not below it.
  TimeEnclosure enclosure();

 private:
  void narrow();
  bool narrow_to(const mpz_class& cell, unsigned bits);
  bool is_root_of(const Polynomial& q) const;
  TimeEnclosure enclosure_of_exact() const;

  bool exact_ = false;
  Polynomial p_;
  Polynomial local_;  // 2^(m n) p((k+s)/2^m), a polynomial in the place s in the interval
  mpz_class k_;
  unsigned m_ = 0;
  unsigned step_bits_ = 0;  // the next step narrows the interval by 2^-step_bits_
  int left_sign_ = 0;       // of p just right of the interval's lower end
};

/// All distinct roots of p, not 0, in [0,1], ascending.
std::vector<Root> roots_in_unit_interval(const Polynomial& p);

}  // namespace selvedge::judging
