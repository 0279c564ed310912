// SPDX-License-Identifier: MIT
//
// Hyper-dual numbers after J. Fike, J. Alonso, "The development of hyper-dual numbers for exact
// second-derivative calculations", AIAA 2011. A function of hyper-dual numbers carries its first
// and second derivatives, exact to rounding and without finite differences.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

namespace selvedge::testing {

/// value + da ε₁ + db ε₂ + dab ε₁ε₂, with ε₁² = ε₂² = 0.
struct HyperDual {
  double value = 0.0, da = 0.0, db = 0.0, dab = 0.0;
  HyperDual() = default;
  HyperDual(double v) : value(v) {}  // NOLINT: numbers are hyper-dual numbers
  HyperDual(double v, double a, double b, double ab) : value(v), da(a), db(b), dab(ab) {}
};

inline HyperDual operator+(const HyperDual& p, const HyperDual& q) {
  return {p.value + q.value, p.da + q.da, p.db + q.db, p.dab + q.dab};
}
inline HyperDual operator-(const HyperDual& p, const HyperDual& q) {
  return {p.value - q.value, p.da - q.da, p.db - q.db, p.dab - q.dab};
}
inline HyperDual operator*(const HyperDual& p, const HyperDual& q) {
  return {p.value * q.value, p.value * q.da + p.da * q.value, p.value * q.db + p.db * q.value,
          p.value * q.dab + p.da * q.db + p.db * q.da + p.dab * q.value};
}
/// f(p), given f and its derivatives at p.value.
inline HyperDual chain(const HyperDual& p, double f, double f1, double f2) {
  return {f, f1 * p.da, f1 * p.db, f1 * p.dab + f2 * p.da * p.db};
}
inline HyperDual operator/(const HyperDual& p, const HyperDual& q) {
  const double r = 1.0 / q.value;
  return p * chain(q, r, -r * r, 2.0 * r * r * r);
}
inline HyperDual sqrt(const HyperDual& p) {
  const double s = std::sqrt(p.value);
  return chain(p, s, 0.5 / s, -0.25 / (s * p.value));
}
inline HyperDual sin(const HyperDual& p) {
  const double s = std::sin(p.value);
  return chain(p, s, std::cos(p.value), -s);
}
inline HyperDual cos(const HyperDual& p) {
  const double c = std::cos(p.value);
  return chain(p, c, -std::sin(p.value), -c);
}
inline HyperDual atan2(const HyperDual& y, const HyperDual& x) {
  // The angle, from its value and the derivative of the rotation at that value.
  const double angle = std::atan2(y.value, x.value), c = std::cos(angle), s = std::sin(angle);
  const HyperDual along = HyperDual(c) * x + HyperDual(s) * y;
  const HyperDual t = (HyperDual(c) * y - HyperDual(s) * x) / along;  // small: atan t = t - t³/3
  return HyperDual(angle) + HyperDual(0.0, t.da, t.db, t.dab);
}

using HyperVec = std::array<HyperDual, 3>;

inline HyperVec operator-(const HyperVec& a, const HyperVec& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline HyperVec operator+(const HyperVec& a, const HyperVec& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline HyperVec operator*(const HyperDual& s, const HyperVec& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
inline HyperDual dot(const HyperVec& a, const HyperVec& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline HyperVec cross(const HyperVec& a, const HyperVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline HyperDual norm(const HyperVec& a) { return sqrt(dot(a, a)); }

}  // namespace selvedge::testing
