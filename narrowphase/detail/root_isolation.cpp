// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/detail/error_bounds.h>
#include <selvedge/narrowphase/detail/root_isolation.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace selvedge::narrowphase_detail {
namespace {

/// Boxes narrower than 2^-kDeepest, or more boxes than kMostBoxes, are left to integers.
constexpr int kDeepest = 30;
constexpr int kMostBoxes = 160;
/// Boxes of this depth on which every root is a contact are not halved to make f monotonic.
constexpr int kMonotonicBy = 12;

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

Quadratic operator-(const Quadratic& a, const Quadratic& b) {
  return {a.b0 - b.b0, a.b1 - b.b1, a.b2 - b.b2};
}

/// A difference of two vertices at both ends.
struct Motion {
  Vec3 d0, d1;
  double largest() const { return std::max(d0.cwiseAbs().maxCoeff(), d1.cwiseAbs().maxCoeff()); }
};

Quadratic cross_component(const Motion& a, const Motion& b, int i) {
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  const auto c = [&](const Vec3& x, const Vec3& y) { return x[j] * y[k] - x[k] * y[j]; };
  return {c(a.d0, b.d0), 0.5 * (c(a.d0, b.d1) + c(a.d1, b.d0)), c(a.d1, b.d1)};
}

/// Stage C. The coplanarity cubic in Bernstein form is halved into boxes, earliest first. A box
/// is dropped if all coefficients have one strict sign (no root), or if a component n_i of n and
/// one constraint have strict signs on it that contradict (no root in it is a contact; see
/// exact_query.cpp). If n_i and all constraints have strict signs that agree, every root in the box
/// is a contact, and if the ends have strict opposite signs there is one. A box that stays open
/// down to the finest width leaves the query open.
class RootIsolation {
 public:
  explicit RootIsolation(const Query& query) : edges_(query.kind == ContactKind::edge_edge) {
    const auto difference = [&](int head, int tail) {
      return Motion{query.x_t0[head] - query.x_t0[tail], query.x_t1[head] - query.x_t1[tail]};
    };
    X_ = difference(edges_ ? 1 : 2, edges_ ? 0 : 1);
    Y_ = difference(3, edges_ ? 2 : 1);
    Z_ = difference(edges_ ? 2 : 0, edges_ ? 0 : 1);
    for (int i = 0; i < 3; ++i) n_[i] = cross_component(X_, Y_, i);
  }

  Verdict run(TimeBox& box) {
    const double a = X_.largest(), b = Y_.largest(), c = Z_.largest();
    const double largest = std::max({a, b, c});
    if (!(std::min({a, b, c}) > kSmallest && largest < kLargest)) return Verdict::open;
    const auto row = [&](double Quadratic::*p) { return Vec3(n_[0].*p, n_[1].*p, n_[2].*p); };
    const Vec3 n0 = row(&Quadratic::b0), n1 = 2.0 * row(&Quadratic::b1), n2 = row(&Quadratic::b2);
    const std::array<double, 4> f{n0.dot(Z_.d0), (n0.dot(Z_.d1) + n1.dot(Z_.d0)) / 3.0,
                                  (n2.dot(Z_.d0) + n1.dot(Z_.d1)) / 3.0, n2.dot(Z_.d1)};
    largest_f_ = 0.0;
    for (const double v : f) largest_f_ = std::max(largest_f_, std::abs(v));
    error_f_ = kBernsteinError * kRoundoff * (a * b * c);
    error_q_ = kConstraintError * kRoundoff * (largest * largest);
    const Verdict verdict = visit(f, 0, 0);
    box = box_;
    return verdict;
  }

 private:
  using Coefficients = std::array<double, 4>;

  Verdict visit(const Coefficients& f, std::int64_t k, int m) {
    // Each halving takes 3 sums on the way of a coefficient, each off by at most u times the
    // largest coefficient.
    const double error = error_f_ + 4.0 * kRoundoff * m * largest_f_;
    if (std::min({f[0], f[1], f[2], f[3]}) > error) return Verdict::no;
    if (std::max({f[0], f[1], f[2], f[3]}) < -error) return Verdict::no;
    if (++boxes_ > kMostBoxes) return Verdict::open;
    const double width = std::ldexp(1.0, -m), lo = static_cast<double>(k) * width, hi = lo + width;
    const Verdict inside = contact_everywhere(lo, hi);
    if (inside == Verdict::no) return Verdict::no;
    const bool crosses = (f[0] > error && f[3] < -error) || (f[0] < -error && f[3] > error);
    if (inside == Verdict::yes && crosses) {
      const double p = f[1] - f[0], q = f[2] - f[1], r = f[3] - f[2], least = 3.0 * error;
      const bool monotonic = std::min({p, q, r}) > least || std::max({p, q, r}) < -least;
      // One root is easier to follow than several: halve on while that promises to help.
      if (monotonic || m >= kMonotonicBy) {
        box_ = {k, m, monotonic};
        return Verdict::yes;
      }
    }
    if (m >= kDeepest) return Verdict::open;
    const double p = 0.5 * (f[0] + f[1]), q = 0.5 * (f[1] + f[2]), r = 0.5 * (f[2] + f[3]);
    const double pq = 0.5 * (p + q), qr = 0.5 * (q + r), middle = 0.5 * (pq + qr);
    const Verdict left = visit({f[0], p, pq, middle}, 2 * k, m + 1);
    if (left != Verdict::no) return left;
    return visit({middle, qr, r, f[3]}, 2 * k + 1, m + 1);
  }

  /// Whether coplanar vertices at any time of the box mean contact: never, always, or it depends.
  Verdict contact_everywhere(double lo, double hi) {
    const double middle = 0.5 * (lo + hi);
    int component = 0;
    double best = -1.0;
    for (int i = 0; i < 3; ++i) {
      const double v = std::abs(n_[i].polar(middle, middle));
      if (v > best) best = v, component = i;
    }
    const int sign = n_[component].strict_sign(lo, hi, error_q_);
    if (sign == 0) return Verdict::open;
    const std::array<Quadratic, 4>& tests = constraints(component);
    Verdict verdict = Verdict::yes;
    for (const Quadratic& q : tests) {
      const int s = sign * q.strict_sign(lo, hi, error_q_);
      if (s < 0) return Verdict::no;
      if (s == 0) verdict = Verdict::open;
    }
    return verdict;
  }

  const std::array<Quadratic, 4>& constraints(int i) {
    if (constrained_ == i) return constraints_;
    constrained_ = i;
    const Quadratic h = cross_component(Z_, Y_, i);
    if (edges_) {
      const Quadratic g = cross_component(Z_, X_, i);
      constraints_ = {h, n_[i] - h, g, n_[i] - g};
    } else {
      const Quadratic g = cross_component(X_, Z_, i);
      const Quadratic rest = n_[i] - h - g;
      constraints_ = {h, g, rest, rest};
    }
    return constraints_;
  }

  bool edges_;
  Motion X_, Y_, Z_;
  std::array<Quadratic, 3> n_;
  double largest_f_ = 0.0, error_f_ = 0.0, error_q_ = 0.0;
  int constrained_ = -1;
  std::array<Quadratic, 4> constraints_;
  int boxes_ = 0;
  TimeBox box_;
};

}  // namespace

Verdict isolate(const Query& query, TimeBox& box) { return RootIsolation(query).run(box); }

}  // namespace selvedge::narrowphase_detail
