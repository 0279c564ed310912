// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/detail/double_double.h>
#include <selvedge/narrowphase/narrow_phase.h>

#include <array>

namespace selvedge::detail {

/// A time known to within half_width.
struct SharpTime {
  DoubleDouble value;
  double half_width;
};

/// The differences of a query at one time; names as in exact_query.cpp.
struct SharpMotion {
  SharpVec X, Y, Z;
};

/// The differences and the coplanarity cubic, sum of c[i] (1-t)^(3-i) t^i, in double-double
/// arithmetic; names as in exact_query.cpp. For queries whose differences lie between kSmallest and
/// kLargest.
class SharpQuery {
 public:
  explicit SharpQuery(const Query& query);

  /// Sign of the cubic at t in [0, 1]; 0 if rounding could have changed it.
  int sign(double t) const { return sign_of(value({t, 0.0})); }
  /// One Newton step from t, and the sign at t as above.
  double newton(double t, int& sign) const;
  /// A root of the cubic between lo and hi, where it has the sign `sign_lo` at lo and the other at
  /// hi, computed in doubles: an estimate without guarantee.
  double rough_root(double lo, double hi, int sign_lo) const;
  /// The root between `floor` and the next double, narrowed, and confirmed by certain signs on both
  /// sides; returns false if that fails.
  bool locate(double floor, SharpTime& time) const;
  SharpMotion at(const DoubleDouble& t) const;
  /// The Bernstein coefficients f(0), c[1]/3, c[2]/3, f(1), each the nearest double up to `error()`
  /// and one or two roundings.
  std::array<double, 4> bernstein() const;
  /// Bound of the error of a value of the cubic.
  double error() const { return error_; }

 private:
  DoubleDouble value(const DoubleDouble& t) const;
  double slope(double t) const;
  int sign_of(const DoubleDouble& v) const { return v.hi > error_ ? 1 : (v.hi < -error_ ? -1 : 0); }

  SharpVec X0_, X1_, Y0_, Y1_, Z0_, Z1_;
  std::array<DoubleDouble, 4> c_;
  double error_ = 0.0;
};

}  // namespace selvedge::detail
