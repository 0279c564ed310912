// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <algorithm>

namespace selvedge::detail {

/// b0 (1-t)^2 + 2 b1 t (1-t) + b2 t^2.
struct Quadratic {
  double b0, b1, b2;

  /// The polar form: q(t, t) is the value at t, and q(lo, lo), q(lo, hi), q(hi, hi) are the
  /// Bernstein coefficients on [lo, hi].
  double polar(double s, double t) const {
    return (1.0 - s) * (1.0 - t) * b0 + ((1.0 - s) * t + s * (1.0 - t)) * b1 + s * t * b2;
  }
  /// Sign on the whole box if it is strict there by more than `error`, else 0.
  int strict_sign(double lo, double hi, double error) const {
    const double p = polar(lo, lo), q = polar(lo, hi), r = polar(hi, hi);
    if (std::min({p, q, r}) > error) return 1;
    if (std::max({p, q, r}) < -error) return -1;
    return 0;
  }
};

inline Quadratic operator-(const Quadratic& a, const Quadratic& b) {
  return {a.b0 - b.b0, a.b1 - b.b1, a.b2 - b.b2};
}

/// A difference of two vertices at both ends.
struct Motion {
  Vec3 d0, d1;
  double largest() const { return std::max(d0.cwiseAbs().maxCoeff(), d1.cwiseAbs().maxCoeff()); }
};

/// Component i of the cross product of two differences; kConstraintError bounds its error.
inline Quadratic cross_component(const Motion& a, const Motion& b, int i) {
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  const auto c = [&](const Vec3& x, const Vec3& y) { return x[j] * y[k] - x[k] * y[j]; };
  return {c(a.d0, b.d0), 0.5 * (c(a.d0, b.d1) + c(a.d1, b.d0)), c(a.d1, b.d1)};
}

}  // namespace selvedge::detail
