// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/cubic.h>

#include <algorithm>
#include <array>
#include <cmath>

// Roots of c[0] + c[1] t + c[2] t^2 + c[3] t^3 in [0, 1] in plain doubles. The stationary points
// cut [0, 1] into pieces on which the cubic is monotonic, hence has one root where its signs at the
// ends differ; Newton's method, kept in the bracket by bisection, finds it.

namespace selvedge::detail {

/// Newton's method stops when t moves by less than this: four times the spacing of doubles below 1.
constexpr double kTimeResolution = 0x1p-51;
/// Bisection alone takes 51 steps to kTimeResolution; the rest allows for rejected Newton steps.
constexpr int kMostRootSteps = 80;

inline double cubic_value(const std::array<double, 4>& c, double t) {
  return ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
}

inline double cubic_slope(const std::array<double, 4>& c, double t) {
  return (3.0 * c[3] * t + 2.0 * c[2]) * t + c[1];
}

/// The root in [lo, hi], where the cubic is monotonic and has the values f_lo and f_hi of opposite
/// signs. Starts at the zero of the secant. A Newton step that leaves the bracket, or is longer
/// than half the previous one, is replaced by a bisection.
inline double root_between(const std::array<double, 4>& c, double lo, double hi, double f_lo,
                           double f_hi) {
  double t = std::clamp(lo + (hi - lo) * (f_lo / (f_lo - f_hi)), lo, hi);
  double last = hi - lo;
  for (int i = 0; i < kMostRootSteps; ++i) {
    const double f = cubic_value(c, t);
    if (f == 0.0) return t;
    ((f > 0.0) == (f_hi > 0.0) ? hi : lo) = t;
    double next = t - f / cubic_slope(c, t);
    if (!(next >= lo && next <= hi && std::abs(next - t) <= 0.5 * last)) next = 0.5 * (lo + hi);
    last = std::abs(next - t);
    t = next;
    if (last <= kTimeResolution) return t;
  }
  return t;
}

/// Writes the stationary points in (0, 1), ascending, and returns their number. Uses t = q / (3 c3)
/// and c1 / q, which avoids cancellation; a division by zero gives no number in (0, 1).
inline int stationary_points(const std::array<double, 4>& c, std::array<double, 2>& t) {
  const double discriminant = c[2] * c[2] - 3.0 * c[3] * c[1];
  if (!(discriminant > 0.0)) return 0;
  const double q = -(c[2] + std::copysign(std::sqrt(discriminant), c[2]));
  int n = 0;
  for (const double s : {q / (3.0 * c[3]), c[1] / q})
    if (s > 0.0 && s < 1.0) t[n++] = s;
  if (n == 2 && t[0] > t[1]) std::swap(t[0], t[1]);
  return n;
}

/// Roots in ascending order. Ends and stationary points where |value| <= touching count as roots
/// too. The coefficients' squares must neither over- nor underflow.
inline void estimate_roots(const std::array<double, 4>& c, double touching,
                           CubicRootEstimates& roots) {
  constexpr double kThird = 1.0 / 3.0;
  roots.count = 0;
  // In Bernstein form, a cubic lies between its smallest and its largest coefficient.
  const double b0 = c[0], b1 = c[0] + kThird * c[1];
  const double b2 = c[0] + kThird * (2.0 * c[1] + c[2]), b3 = cubic_value(c, 1.0);
  if (std::min(std::min(b0, b1), std::min(b2, b3)) > touching ||
      std::max(std::max(b0, b1), std::max(b2, b3)) < -touching)
    return;
  std::array<double, 2> stationary;
  const int n = stationary_points(c, stationary);
  double lo = 0.0, f_lo = b0;
  for (int i = 0; i <= n; ++i) {
    const double hi = i < n ? stationary[i] : 1.0;
    const double f_hi = i < n ? cubic_value(c, hi) : b3;
    if (std::abs(f_lo) <= touching) roots.t[roots.count++] = lo;
    if ((f_lo < 0.0 && f_hi > 0.0) || (f_lo > 0.0 && f_hi < 0.0))
      roots.t[roots.count++] = root_between(c, lo, hi, f_lo, f_hi);
    lo = hi, f_lo = f_hi;
  }
  if (std::abs(f_lo) <= touching) roots.t[roots.count++] = 1.0;
}

}  // namespace selvedge::detail
