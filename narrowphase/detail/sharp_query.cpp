// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/detail/error_bounds.h>
#include <selvedge/narrowphase/detail/sharp_query.h>

#include <algorithm>
#include <cmath>

namespace selvedge::detail {
namespace {

double largest(const SharpVec& a, const SharpVec& b) {
  double m = 0.0;
  for (int i = 0; i < 3; ++i) m = std::max({m, std::abs(a[i].hi), std::abs(b[i].hi)});
  return m;
}

SharpVec between(const SharpVec& x0, const SharpVec& x1, const DoubleDouble& t) {
  const DoubleDouble s = DoubleDouble{1.0, 0.0} - t;
  SharpVec x;
  for (int i = 0; i < 3; ++i) x[i] = s * x0[i] + t * x1[i];
  return x;
}

}  // namespace

SharpQuery::SharpQuery(const Query& q) {
  const bool edges = q.kind == ContactKind::edge_edge;
  const int base = edges ? 0 : 1, second = edges ? 2 : 1;
  const auto ends = [&](int head, int tail, SharpVec& d0, SharpVec& d1) {
    d0 = difference(q.x_t0[head], q.x_t0[tail]);
    d1 = difference(q.x_t1[head], q.x_t1[tail]);
  };
  ends(edges ? 1 : 2, base, X0_, X1_);
  ends(3, second, Y0_, Y1_);
  ends(edges ? 2 : 0, base, Z0_, Z1_);
  const SharpVec n0 = cross(X0_, Y0_), n2 = cross(X1_, Y1_);
  const SharpVec n1 = cross(X0_, Y1_) + cross(X1_, Y0_);
  c_ = {dot(n0, Z0_), dot(n0, Z1_) + dot(n1, Z0_), dot(n2, Z0_) + dot(n1, Z1_), dot(n2, Z1_)};
  error_ = kSharpCubicError * (largest(X0_, X1_) * largest(Y0_, Y1_) * largest(Z0_, Z1_));
}

DoubleDouble SharpQuery::value(const DoubleDouble& x) const {
  const DoubleDouble y = DoubleDouble{1.0, 0.0} - x, xx = x * x, yy = y * y;
  return y * (yy * c_[0] + x * (y * c_[1])) + xx * (y * c_[2] + x * c_[3]);
}

double SharpQuery::slope(double t) const {
  const double s = 1.0 - t;
  return s * s * (c_[1].hi - 3.0 * c_[0].hi) + 2.0 * s * t * (c_[2].hi - c_[1].hi) +
         t * t * (3.0 * c_[3].hi - c_[2].hi);
}

double SharpQuery::newton(double t, int& sign) const {
  const DoubleDouble v = value({t, 0.0});
  sign = sign_of(v);
  return t - v.hi / slope(t);
}

bool SharpQuery::locate(double floor, SharpTime& time) const {
  const DoubleDouble v = value({floor, 0.0});
  const int sign_lo = sign_of(v);
  const double step = -v.hi / slope(floor), half_width = kLocated * step;
  if (!(half_width > 0.0) || sign_lo == 0) return false;
  time = {two_sum(floor, step), half_width};
  return sign_of(value(two_sum(floor, step - half_width))) == sign_lo &&
         sign_of(value(two_sum(floor, step + half_width))) == -sign_lo;
}

SharpMotion SharpQuery::at(const DoubleDouble& t) const {
  return {between(X0_, X1_, t), between(Y0_, Y1_, t), between(Z0_, Z1_, t)};
}

double SharpQuery::rough_root(double lo, double hi, int sign_lo) const {
  constexpr int kSteps = 12;
  double t = lo + 0.5 * (hi - lo);
  for (int step = 0; step < kSteps; ++step) {
    const double s = 1.0 - t;
    const double v = s * s * (s * c_[0].hi + t * c_[1].hi) + t * t * (s * c_[2].hi + t * c_[3].hi);
    ((v > 0.0) == (sign_lo > 0) ? lo : hi) = t;
    const double next = t - v / slope(t);
    const double inside = next > lo && next < hi ? next : lo + 0.5 * (hi - lo);
    if (std::abs(inside - t) <= 2.0 * kRoundoff * t) break;
    t = inside;
  }
  return t;
}

std::array<double, 4> SharpQuery::bernstein() const {
  return {c_[0].hi, c_[1].hi / 3.0, c_[2].hi / 3.0, c_[3].hi};
}

}  // namespace selvedge::detail
