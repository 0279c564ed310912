// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/detail/root_floor.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace selvedge::narrowphase_detail {
namespace {

/// hi + lo with |lo| at most half an ulp of hi: 106 bits. Sums and products are off by at most
/// 7 * 2^-106 of the result [JoldesMullerPopescu2017] algorithms 6 and 10.
struct DoubleDouble {
  double hi = 0.0, lo = 0.0;
};

/// a + b exactly [Knuth 1969].
DoubleDouble two_sum(double a, double b) {
  const double s = a + b, t = s - a;
  return {s, (a - (s - t)) + (b - t)};
}

/// a + b exactly for |a| >= |b| [Dekker 1971].
DoubleDouble fast_two_sum(double a, double b) {
  const double s = a + b;
  return {s, b - (s - a)};
}

/// a * b exactly by splitting both into halves [Dekker 1971].
DoubleDouble two_product(double a, double b) {
  constexpr double kSplitter = 0x1p27 + 1.0;
  const double ca = kSplitter * a, cb = kSplitter * b;
  const double ah = ca - (ca - a), bh = cb - (cb - b);
  const double al = a - ah, bl = b - bh, p = a * b;
  return {p, ((ah * bh - p) + ah * bl + al * bh) + al * bl};
}

DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble s = two_sum(a.hi, b.hi), t = two_sum(a.lo, b.lo);
  const DoubleDouble v = fast_two_sum(s.hi, s.lo + t.hi);
  return fast_two_sum(v.hi, t.lo + v.lo);
}

DoubleDouble operator-(const DoubleDouble& a) { return {-a.hi, -a.lo}; }
DoubleDouble operator-(const DoubleDouble& a, const DoubleDouble& b) { return a + -b; }

DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble p = two_product(a.hi, b.hi);
  return fast_two_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

using Vec = std::array<DoubleDouble, 3>;

Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vec operator+(const Vec& a, const Vec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

DoubleDouble dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vec difference(const Vec3& a, const Vec3& b) {
  return {two_sum(a[0], -b[0]), two_sum(a[1], -b[1]), two_sum(a[2], -b[2])};
}

double largest(const Vec& a, const Vec& b) {
  double m = 0.0;
  for (int i = 0; i < 3; ++i) m = std::max({m, std::abs(a[i].hi), std::abs(b[i].hi)});
  return m;
}

/// The coplanarity cubic, sum of c[i] (1-t)^(3-i) t^i; names as in exact_query.cpp.
class Cubic {
 public:
  explicit Cubic(const Query& q) {
    const bool edges = q.kind == ContactKind::edge_edge;
    const int base = edges ? 0 : 1, second = edges ? 2 : 1;
    const auto ends = [&](int head, int tail, Vec& d0, Vec& d1) {
      d0 = difference(q.x_t0[head], q.x_t0[tail]);
      d1 = difference(q.x_t1[head], q.x_t1[tail]);
    };
    Vec X0, X1, Y0, Y1, Z0, Z1;
    ends(edges ? 1 : 2, base, X0, X1);
    ends(3, second, Y0, Y1);
    ends(edges ? 2 : 0, base, Z0, Z1);
    const Vec n0 = cross(X0, Y0), n1 = cross(X0, Y1) + cross(X1, Y0), n2 = cross(X1, Y1);
    c_ = {dot(n0, Z0), dot(n0, Z1) + dot(n1, Z0), dot(n2, Z0) + dot(n1, Z1), dot(n2, Z1)};
    // Each c is a sum of at most 18 products of size 1 (in units of the three largest coordinates)
    // that go through at most 10 operations, and the value at t adds at most 8 operations on
    // terms whose sum is at most 18: 18 * (10 + 8) * 7 < 2^12 units of 2^-106.
    constexpr double kError = 0x1p-94;
    error_ = kError * (largest(X0, X1) * largest(Y0, Y1) * largest(Z0, Z1));
  }

  DoubleDouble value(double t) const {
    const DoubleDouble x{t, 0.0}, y = two_sum(1.0, -t);
    const DoubleDouble xx = x * x, yy = y * y;
    return y * (yy * c_[0] + x * (y * c_[1])) + xx * (y * c_[2] + x * c_[3]);
  }

  double slope(double t) const {
    const double s = 1.0 - t;
    return s * s * (c_[1].hi - 3.0 * c_[0].hi) + 2.0 * s * t * (c_[2].hi - c_[1].hi) +
           t * t * (3.0 * c_[3].hi - c_[2].hi);
  }

  /// Sign of a value, 0 where rounding could have turned it.
  int sign(const DoubleDouble& v) const { return v.hi > error_ ? 1 : (v.hi < -error_ ? -1 : 0); }

 private:
  std::array<DoubleDouble, 4> c_;
  double error_;
};

}  // namespace

bool floor_of_root(const Query& query, std::int64_t k, int m, double& root) {
  const Cubic f(query);
  double lo = std::ldexp(static_cast<double>(k), -m),
         hi = std::ldexp(static_cast<double>(k + 1), -m);
  const int sign_lo = f.sign(f.value(lo));
  if (sign_lo == 0 || f.sign(f.value(hi)) != -sign_lo) return false;
  // Newton's method kept inside the bracket [lo, hi], whose ends have certain signs; where a step
  // hardly moves, the neighbouring double closes the bracket.
  constexpr int kSteps = 80;
  double t = 0.5 * (lo + hi);
  for (int step = 0; step < kSteps; ++step) {
    if (std::nextafter(lo, hi) == hi) {
      root = lo;
      return true;
    }
    if (!(t > lo && t < hi)) t = 0.5 * (lo + hi);
    const DoubleDouble v = f.value(t);
    const int s = f.sign(v);
    if (s == 0) return false;
    (s == sign_lo ? lo : hi) = t;
    double next = t - v.hi / f.slope(t);
    if (next == t || !(next > lo && next < hi))
      next = s == sign_lo ? std::nextafter(t, 2.0) : std::nextafter(t, -1.0);
    if (step % 8 == 7) next = 0.5 * (lo + hi);
    t = next;
  }
  return false;
}

}  // namespace selvedge::narrowphase_detail
