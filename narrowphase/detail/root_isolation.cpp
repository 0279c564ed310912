// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/detail/error_bounds.h>
#include <selvedge/narrowphase/detail/exact_query.h>
#include <selvedge/narrowphase/detail/quadratic.h>
#include <selvedge/narrowphase/detail/root_floor.h>
#include <selvedge/narrowphase/detail/root_isolation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

namespace selvedge::detail {
namespace {

/// Boxes narrower than 2^-kDeepest, or more boxes than allowed, leave the query open. The first
/// pass has a low limit: queries that it does not decide soon need the more accurate cubic.
constexpr int kDeepest = 30;
constexpr int kFirstPassBoxes = 24, kMostBoxes = 160;

/// A quadratic that, times the sign of n_i, must not be negative. `size` is the unit of its error.
struct Constraint {
  Quadratic q;
  double size;
};

DoubleDouble component(const SharpVec& a, const SharpVec& b, int i) {
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  return a[j] * b[k] - a[k] * b[j];
}

/// Stage C. Halves the coplanarity cubic in Bernstein form into boxes, earliest first. A box is
/// dropped if all coefficients have one strict sign (no root), or if a component n_i of n and one
/// constraint have strict contradicting signs on it (no root in it is a contact; see
/// exact_query.cpp). If the cubic is monotonic on a box and changes sign, it has one root, which is
/// narrowed to neighbouring doubles. If n_i and all constraints have strict agreeing signs there,
/// it is the first contact; if two contradict, it is not a contact; otherwise integers decide. If
/// the finest box is still undecided, the query stays open.
class RootIsolation {
 public:
  /// `query` may be `original` times a power of two.
  RootIsolation(const Query& query, const Query& original)
      : query_(query), original_(original), edges_(query.kind == ContactKind::edge_edge) {
    const auto difference = [&](int head, int tail) {
      return Motion{query.x_t0[head] - query.x_t0[tail], query.x_t1[head] - query.x_t1[tail]};
    };
    X_ = difference(edges_ ? 1 : 2, edges_ ? 0 : 1);
    Y_ = difference(3, edges_ ? 2 : 1);
    Z_ = difference(edges_ ? 2 : 0, edges_ ? 0 : 1);
    for (int i = 0; i < 3; ++i) n_[i] = cross_component(X_, Y_, i);
  }

  double largest_difference() const { return std::max({X_.largest(), Y_.largest(), Z_.largest()}); }
  /// See kSmallest: a small factor may be compensated by a large one.
  bool is_in_range() const {
    const double a = X_.largest(), b = Y_.largest(), c = Z_.largest();
    return std::min({a * b, b * c, c * a}) > kSmallest * kSmallest &&
           std::max({a, b, c}) < kLargest;
  }

  ContactDecision run(double& toi, bool& is_exact) {
    const double a = X_.largest(), b = Y_.largest(), c = Z_.largest();
    size_n_ = a * b, size_h_ = c * b, size_g_ = a * c;
    if (contact_everywhere(0.0, 1.0) == ContactDecision::no) return ContactDecision::no;
    const Coefficients f = bernstein();
    const double error = kBernsteinError * kRoundoff * (a * b * c);
    ContactDecision decision = ContactDecision::open;
    if (std::min(std::abs(f[0]), std::abs(f[3])) > error)
      decision = pass(f, error, kFirstPassBoxes);
    if (decision == ContactDecision::open) decision = sharp_pass();
    toi = root_.floor;
    is_exact = is_exact_;
    return decision;
  }

 private:
  using Coefficients = std::array<double, 4>;

  Coefficients bernstein() const {
    const auto row = [&](double Quadratic::*p) { return Vec3(n_[0].*p, n_[1].*p, n_[2].*p); };
    const Vec3 n0 = row(&Quadratic::b0), n1 = 2.0 * row(&Quadratic::b1), n2 = row(&Quadratic::b2);
    return {n0.dot(Z_.d0), (n0.dot(Z_.d1) + n1.dot(Z_.d0)) / 3.0,
            (n2.dot(Z_.d0) + n1.dot(Z_.d1)) / 3.0, n2.dot(Z_.d1)};
  }

  const SharpQuery& sharp() {
    if (!sharp_) sharp_.emplace(query_);
    return *sharp_;
  }

  ContactDecision sharp_pass() {
    const SharpQuery& f = sharp();
    const Coefficients b = f.bernstein();
    const auto is_null = [&](double v) { return std::abs(v) <= f.error(); };
    const auto may_touch = [&](double lo, double hi) {
      return contact_everywhere(lo, hi) != ContactDecision::no;
    };
    // Halving would not end before the smallest boxes.
    const double smallest = std::ldexp(1.0, -kDeepest);
    if (std::all_of(b.begin(), b.end(), is_null) || (is_null(b[0]) && may_touch(0.0, smallest)) ||
        (is_null(b[3]) && may_touch(1.0 - smallest, 1.0)))
      return ContactDecision::open;
    use_sharp_signs_ = true;
    return pass(b, f.error(), kMostBoxes);
  }

  ContactDecision pass(const Coefficients& f, double error, int boxes) {
    boxes_left_ = boxes;
    root_ = {};
    error_f_ = error;
    largest_f_ = 0.0;
    for (const double v : f) largest_f_ = std::max(largest_f_, std::abs(v));
    return visit(f, 0, 0);
  }

  ContactDecision visit(const Coefficients& f, std::int64_t k, int m) {
    // The initial coefficients may be rounded twice. Each halving adds at most 3 sums to a
    // coefficient, each off by at most u times the largest coefficient.
    const double error = error_f_ + (4.0 * m + 2.0) * kRoundoff * largest_f_;
    const double width = std::ldexp(1.0, -m), lo = static_cast<double>(k) * width, hi = lo + width;
    if (has_one_sign(f, lo, hi, error)) return ContactDecision::no;
    if (--boxes_left_ < 0) return ContactDecision::open;
    const ContactDecision inside = contact_everywhere(lo, hi);
    if (inside == ContactDecision::no) return ContactDecision::no;
    const double p = f[1] - f[0], q = f[2] - f[1], r = f[3] - f[2], least = 3.0 * error;
    const bool monotonic = std::min({p, q, r}) > least || std::max({p, q, r}) < -least;
    const int sign_lo = monotonic ? sign_at(lo, f[0], error) : 0;
    if (sign_lo != 0 && sign_at(hi, f[3], error) == -sign_lo) return decide_root(lo, hi, sign_lo);
    if (m >= kDeepest) return ContactDecision::open;
    const double a = 0.5 * (f[0] + f[1]), b = 0.5 * (f[1] + f[2]), c = 0.5 * (f[2] + f[3]);
    const double ab = 0.5 * (a + b), bc = 0.5 * (b + c), middle = 0.5 * (ab + bc);
    const ContactDecision left = visit({f[0], a, ab, middle}, 2 * k, m + 1);
    if (left != ContactDecision::no) return left;
    return visit({middle, bc, c, f[3]}, 2 * k + 1, m + 1);
  }

  /// Certain sign of f at time t, where its value is about v; 0 if it is not certain.
  int sign_at(double t, double v, double error) {
    if (v > error) return 1;
    if (v < -error) return -1;
    return use_sharp_signs_ ? sharp().sign(t) : 0;
  }

  bool has_one_sign(const Coefficients& f, double lo, double hi, double error) {
    const double inner_lo = std::min(f[1], f[2]), inner_hi = std::max(f[1], f[2]);
    if (inner_lo > error) return sign_at(lo, f[0], error) > 0 && sign_at(hi, f[3], error) > 0;
    if (inner_hi < -error) return sign_at(lo, f[0], error) < 0 && sign_at(hi, f[3], error) < 0;
    return false;
  }

  /// Decides the only root of f strictly between lo and hi.
  ContactDecision decide_root(double lo, double hi, int sign_lo) {
    ContactDecision decision = ContactDecision::open;
    SharpTime time;
    root_ = {.lo = lo, .hi = hi, .floor = lo, .sign_lo = sign_lo};
    if (floor_of_root(sharp(), root_)) {
      decision = contact_everywhere(root_.lo, root_.hi);
      if (decision == ContactDecision::open && sharp().locate(root_.floor, time))
        decision = contact_at(time);
    }
    if (decision != ContactDecision::open) return decision;
    is_exact_ = true;
    return touches_exactly(original_, root_) ? ContactDecision::yes : ContactDecision::no;
  }

  ContactDecision contact_at(const SharpTime& time) {
    const int i = largest_component(time.value.hi);
    const auto [X, Y, Z] = sharp().at(time.value);
    const DoubleDouble n = component(X, Y, i), h = component(Z, Y, i);
    const DoubleDouble g = edges_ ? component(Z, X, i) : component(X, Z, i);
    const std::array<DoubleDouble, 4> tests{h, edges_ ? n - h : n - h - g, g, n - g};
    const double error = kSharpConstraintError + kConstraintSlope * time.half_width;
    const auto sign_of = [error](const DoubleDouble& v, double size) {
      return v.hi > error * size ? 1 : (v.hi < -error * size ? -1 : 0);
    };
    const int sign = sign_of(n, size_n_);
    if (sign == 0) return ContactDecision::open;
    ContactDecision decision = ContactDecision::yes;
    for (int k = 0; k < (edges_ ? 4 : 3); ++k) {
      const int s = sign * sign_of(tests[k], size_n_ + size_h_ + size_g_);
      if (s < 0) return ContactDecision::no;
      if (s == 0) decision = ContactDecision::open;
    }
    return decision;
  }

  /// Of n at t.
  int largest_component(double t) const {
    int largest = 0;
    double best = -1.0;
    for (int i = 0; i < 3; ++i) {
      const double v = std::abs(n_[i].polar(t, t));
      if (v > best) best = v, largest = i;
    }
    return largest;
  }

  /// Whether coplanar vertices mean contact at every time of the box, at none, or at some.
  ContactDecision contact_everywhere(double lo, double hi) {
    const int i = largest_component(0.5 * (lo + hi));
    const int sign = n_[i].strict_sign(lo, hi, kConstraintError * kRoundoff * size_n_);
    if (sign == 0) return ContactDecision::open;
    ContactDecision decision = ContactDecision::yes;
    for (const Constraint& c : constraints(i)) {
      const int s = sign * c.q.strict_sign(lo, hi, kConstraintError * kRoundoff * c.size);
      if (s < 0) return ContactDecision::no;
      if (s == 0) decision = ContactDecision::open;
    }
    return decision;
  }

  std::span<const Constraint> constraints(int i) {
    if (constrained_ != i) {
      constrained_ = i;
      const Constraint h{cross_component(Z_, Y_, i), size_h_};
      if (edges_) {
        const Constraint g{cross_component(Z_, X_, i), size_g_};
        constraints_ = {h, {n_[i] - h.q, size_n_ + size_h_}, g, {n_[i] - g.q, size_n_ + size_g_}};
      } else {
        const Constraint g{cross_component(X_, Z_, i), size_g_};
        constraints_ = {h, g, {n_[i] - h.q - g.q, size_n_ + size_h_ + size_g_}};
      }
    }
    return std::span(constraints_).first(edges_ ? 4 : 3);
  }

  const Query &query_, &original_;
  bool edges_;
  Motion X_, Y_, Z_;
  std::array<Quadratic, 3> n_;
  double size_n_ = 0.0, size_h_ = 0.0, size_g_ = 0.0;
  int constrained_ = -1;
  std::array<Constraint, 4> constraints_;

  // Values of the current pass.
  double largest_f_ = 0.0, error_f_ = 0.0;
  int boxes_left_ = 0;
  bool use_sharp_signs_ = false;
  std::optional<SharpQuery> sharp_;
  IsolatedRoot root_;
  bool is_exact_ = false;
};

/// Loses only bits that underflow while the largest difference is about 1, which the reserve of the
/// bounds covers. Times do not change.
Query times_power_of_two(const Query& query, int exponent) {
  Query scaled = query;
  for (auto* x : {&scaled.x_t0, &scaled.x_t1})
    for (Vec3& v : *x)
      for (int i = 0; i < 3; ++i) v[i] = std::ldexp(v[i], exponent);
  return scaled;
}

}  // namespace

ContactDecision isolate_contact(const Query& query, double& toi, bool& is_exact) {
  is_exact = false;
  RootIsolation isolation(query, query);
  if (isolation.is_in_range()) return isolation.run(toi, is_exact);
  const double size = isolation.largest_difference();
  if (!(size > 0.0 && std::isfinite(size))) return ContactDecision::open;
  const Query scaled = times_power_of_two(query, -std::ilogb(size));
  RootIsolation scaled_isolation(scaled, query);
  return scaled_isolation.is_in_range() ? scaled_isolation.run(toi, is_exact)
                                        : ContactDecision::open;
}

}  // namespace selvedge::detail
