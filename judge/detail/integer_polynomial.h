// SPDX-License-Identifier: MIT
#pragma once

#include <gmpxx.h>

#include <utility>
#include <vector>

namespace selvedge::judging {

/// A polynomial with integer coefficients, constant first. The last coefficient is not 0; the zero
/// polynomial is empty.
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

/// True if the signs of the Bernstein coefficients prove that p has no root in [0,1]. False proves
/// nothing. p must not be 0.
bool has_evidently_no_root(const Polynomial& p);

/// A real number in [0,1], enclosed by neighbouring doubles; lo == hi if and only if it is a
/// double.
struct TimeEnclosure {
  double lo, hi;
};

/// A real root in [0,1] of a polynomial. It is either a dyadic number, or the only root of a
/// polynomial in the open interval (k/2^m, (k+1)/2^m), where it is simple. Sign queries narrow the
/// interval.
class Root {
 public:
  explicit Root(DyadicTime t) : exact_(true), k_(std::move(t.numerator)), m_(t.exponent) {}
  Root(Polynomial p, mpz_class k, unsigned m);

  /// Sign of q at the root. Exact.
  int sign_of(const Polynomial& q);
  /// lo is the largest double not above the root, hi the smallest double not below it.
  TimeEnclosure enclosure();

 private:
  void narrow();
  bool narrow_to(const mpz_class& cell, unsigned bits);
  bool is_root_of(const Polynomial& q) const;
  TimeEnclosure enclosure_of_exact() const;

  bool exact_ = false;
  Polynomial p_;
  Polynomial local_;  // 2^(m n) p((k+s)/2^m), where s in [0,1] is the position in the interval
  mpz_class k_;
  unsigned m_ = 0;
  unsigned step_bits_ = 0;  // the next step narrows the interval by 2^-step_bits_
  int left_sign_ = 0;       // sign of p just right of the lower end
};

/// All distinct roots of p in [0,1], in ascending order. p must not be 0.
std::vector<Root> roots_in_unit_interval(const Polynomial& p);

}  // namespace selvedge::judging
