// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/internal/big_int.h>
#include <selvedge/narrowphase/detail/fixed_int.h>

#include <array>
#include <vector>

namespace selvedge::detail {

/// Int is BigInt, or a FixedInt whose DoesNotFit the caller catches.
///
/// p(t) = sum over i of c[i] (1 - t)^(degree - i) t^i with integer c: the Bernstein form with the
/// binomials multiplied in. It is also the polynomial sum of c[i] u^i in u = t / (1 - t), which
/// maps [0, 1] onto [0, infinity] in order. Products are therefore plain convolutions, the values
/// at t = 0 and t = 1 are the outer coefficients, and Descartes' rule of signs counts roots in (0,
/// 1).
template <class Int>
struct Polynomial {
  static constexpr int kMaxDegree = 4;
  int degree = 0;  ///< formal degree; outer coefficients may be zero
  std::array<Int, kMaxDegree + 1> c;

  bool is_zero() const;
};

template <class Int>
Polynomial<Int> operator-(const Polynomial<Int>& a, const Polynomial<Int>& b);  ///< of equal degree
template <class Int>
Polynomial<Int> operator*(const Polynomial<Int>& a, const Polynomial<Int>& b);
/// r += a * b, or -= if `negate`; r has the degree of the product.
template <class Int>
void add_product(Polynomial<Int>& r, const Polynomial<Int>& a, const Polynomial<Int>& b,
                 bool negate = false);

/// Sign of p at t = k / 2^m, 0 <= k <= 2^m.
template <class Int>
int sign_at(const Polynomial<Int>& p, const Int& k, int m);

/// The times from k / 2^m to (k + width) / 2^m, within [0, 1].
template <class Int>
struct Box {
  Int k, width{1};
  int m = 0;
  Int end() const { return k + width; }
};

/// A t in [0, 1] where a polynomial is zero: either a rational number, or an algebraic number known
/// as the only root of a polynomial strictly between two dyadic numbers.
template <class Int>
class Root {
 public:
  /// t = num / (num + den); both are nonnegative and not both zero.
  static Root rational(Int num, Int den);
  /// The only root of p in the open box, a simple one; to its left p has the sign `sign_lo`.
  static Root isolated(Polynomial<Int> p, Box<Int> box, int sign_lo);
  /// The same between two doubles.
  static Root between_doubles(Polynomial<Int> p, double lo, double hi, int sign_lo);
  /// The same, near the double t between lo and hi: first searched for there.
  static Root near_double(const Polynomial<Int>& p, double lo, double t, double hi, int sign_lo);

  /// Exact sign of q at the root, for q of degree at most 2 (or any degree at a rational root).
  int sign(const Polynomial<Int>& q);
  /// Sign of q at the root if a cheap test shows that it is not zero, otherwise 0.
  int sign_if_clear(const Polynomial<Int>& q) const;
  /// The largest double not above the root. `exact` tells whether it equals the root.
  double floor(bool& exact) const;
  /// A double not above the root, at once: the start of its box.
  double lower_bound() const;
  int multiplicity = 1;

 private:
  static Root at_double(double t);
  double quotient() const;
  bool is_quotient(double t) const;
  double floor_in_box(bool& exact) const;
  void bisect();
  void narrow();
  double guess() const;
  int sign_in_doubles(const Polynomial<Int>& q) const;
  int side(int sign_p, int lo, int hi) const;
  int sign_of_linear(const Polynomial<Int>& q);
  int sign_by_remainder(Polynomial<Int> q);
  void become(Int num, Int den);
  void become_border(std::int64_t cell, int bits);

  bool rational_ = true;
  Int num_, den_;
  Polynomial<Int> p_;
  Box<Int> box_;
  int sign_lo_ = 0;
};

/// Appends the distinct roots of p in the closed interval [0, 1] in ascending order. p is of degree
/// at most 3 and not identically zero.
template <class Int>
void isolate_roots(const Polynomial<Int>& p, std::vector<Root<Int>>& roots);

}  // namespace selvedge::detail
