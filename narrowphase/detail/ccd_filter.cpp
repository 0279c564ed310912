// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/detail/ccd_filter.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace selvedge::narrowphase_detail {
namespace {

/// Unit roundoff u of double.
constexpr double kRoundoff = 0x1p-53;

/// Stages B and C work on queries whose largest differences lie in this range: then products of
/// three of them neither overflow nor lose more to underflow (2^-1074 against at least 2^-800 * u)
/// than the reserve in the bounds covers.
constexpr double kSmallest = 0x1p-260, kLargest = 0x1p260;

/// Bound of |computed - exact| of the coefficients of the coplanarity cubic, in units of
/// u * max|X| * max|Y| * max|Z| (coordinates of the computed differences). Each coefficient is a
/// sum of at most 18 products of three differences. On the way of a product into the sum lie 3
/// roundings of differences, 2 of products and at most 5 of sums: 18 * 10 = 180, and the rest is
/// reserve for terms of order u^2, for computing the bound itself and for underflow.
constexpr double kCubicError = 192.0;

/// N doubles that the compiler keeps in vector registers, and masks of the same shape.
template <int N>
struct Simd {
  typedef double V __attribute__((vector_size(N * 8)));
  typedef std::int64_t M __attribute__((vector_size(N * 8)));
};

#define SELVEDGE_INLINE inline __attribute__((always_inline))

template <int N>
struct Kernel {
  using V = typename Simd<N>::V;
  using M = typename Simd<N>::M;

  static SELVEDGE_INLINE V load(const double* p) { return *reinterpret_cast<const V*>(p); }
  static SELVEDGE_INLINE V min(V a, V b) { return a < b ? a : b; }
  static SELVEDGE_INLINE V max(V a, V b) { return a > b ? a : b; }
  static SELVEDGE_INLINE V abs(V a) { return max(a, -a); }

  static SELVEDGE_INLINE std::uint32_t bits(M m) {
    std::uint32_t r = 0;
    for (int j = 0; j < N; ++j) r |= static_cast<std::uint32_t>(m[j] & 1) << j;
    return r;
  }

  static SELVEDGE_INLINE bool all(M m) {
    std::int64_t r = -1;
    for (int j = 0; j < N; ++j) r &= m[j];
    return r != 0;
  }

  /// Columns where along one axis every vertex of one primitive lies strictly below every vertex
  /// of the other, at both ends in the same order. v[k] and w[k] are the places of vertex k.
  template <int First>
  static SELVEDGE_INLINE M ordered(const V (&v)[4], const V (&w)[4]) {
    V lo0 = v[0], hi0 = v[0], lo1 = w[0], hi1 = w[0];
    if constexpr (First == 2) {
      lo0 = min(v[0], v[1]), hi0 = max(v[0], v[1]);
      lo1 = min(w[0], w[1]), hi1 = max(w[0], w[1]);
    }
    V second_lo0 = min(v[2], v[3]), second_hi0 = max(v[2], v[3]);
    V second_lo1 = min(w[2], w[3]), second_hi1 = max(w[2], w[3]);
    if constexpr (First == 1) {
      second_lo0 = min(second_lo0, v[1]), second_hi0 = max(second_hi0, v[1]);
      second_lo1 = min(second_lo1, w[1]), second_hi1 = max(second_hi1, w[1]);
    }
    const M below = (hi0 < second_lo0) & (hi1 < second_lo1);
    const M above = (lo0 > second_hi0) & (lo1 > second_hi1);
    return below | above;
  }

  /// Stage A. Along an axis, the difference of two vertices is linear in t; strictly positive at
  /// both ends it is positive throughout, and so is that of any two points of the primitives: they
  /// share no point. The axes are x, y, z and x+-y, y+-z, z+-x. There one rounding stands between
  /// the coordinates and the compared numbers, and rounding is monotonic: where the rounded
  /// numbers are strictly ordered, so are the exact ones (also if one overflowed to infinity).
  template <int First>
  static SELVEDGE_INLINE M separated(const QueryBlock& q, int at) {
    M found = {};
    V v[4], w[4];
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 4; ++k) {
        v[k] = load(&q.x_t0[3 * k + i][at]);
        w[k] = load(&q.x_t1[3 * k + i][at]);
      }
      found |= ordered<First>(v, w);
    }
    if (all(found)) return found;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      V v_minus[4], w_minus[4];
      for (int k = 0; k < 4; ++k) {
        const V vi = load(&q.x_t0[3 * k + i][at]), vj = load(&q.x_t0[3 * k + j][at]);
        const V wi = load(&q.x_t1[3 * k + i][at]), wj = load(&q.x_t1[3 * k + j][at]);
        v[k] = vi + vj, w[k] = wi + wj;
        v_minus[k] = vi - vj, w_minus[k] = wi - wj;
      }
      found |= ordered<First>(v, w) | ordered<First>(v_minus, w_minus);
    }
    return found;
  }

  static SELVEDGE_INLINE void cross(const V (&a)[3], const V (&b)[3], V (&out)[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
  }

  static SELVEDGE_INLINE V dot(const V (&a)[3], const V (&b)[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  }

  static SELVEDGE_INLINE V largest(const V (&a)[3], const V (&b)[3]) {
    return max(max(max(abs(a[0]), abs(a[1])), abs(a[2])),
               max(max(abs(b[0]), abs(b[1])), abs(b[2])));
  }

  /// Stage B. f(t) = sum of c[i] (1-t)^(3-i) t^i with c from the differences at both ends; if all
  /// c[i] exceed their error bound with one sign, f is not zero in [0, 1], the vertices are never
  /// coplanar and the primitives never touch. Names as in exact_query.cpp.
  template <int First>
  static SELVEDGE_INLINE M never_coplanar(const QueryBlock& q, int at) {
    constexpr int kBase = First == 1 ? 1 : 0;
    V X0[3], X1[3], Y0[3], Y1[3], Z0[3], Z1[3];
    const auto difference = [&](int head, int tail, V(&d0)[3], V(&d1)[3]) {
      for (int i = 0; i < 3; ++i) {
        d0[i] = load(&q.x_t0[3 * head + i][at]) - load(&q.x_t0[3 * tail + i][at]);
        d1[i] = load(&q.x_t1[3 * head + i][at]) - load(&q.x_t1[3 * tail + i][at]);
      }
    };
    difference(First == 1 ? 2 : 1, kBase, X0, X1);
    difference(3, First == 1 ? 1 : 2, Y0, Y1);
    difference(First == 1 ? 0 : 2, kBase, Z0, Z1);
    V n0[3], n1[3], n2[3], mixed[3];
    cross(X0, Y0, n0);
    cross(X1, Y1, n2);
    cross(X0, Y1, n1);
    cross(X1, Y0, mixed);
    for (int i = 0; i < 3; ++i) n1[i] += mixed[i];
    const V c0 = dot(n0, Z0), c3 = dot(n2, Z1);
    const V c1 = dot(n0, Z1) + dot(n1, Z0), c2 = dot(n2, Z0) + dot(n1, Z1);
    const V a = largest(X0, X1), b = largest(Y0, Y1), c = largest(Z0, Z1);
    const V error = (kCubicError * kRoundoff) * (a * b * c);
    const M in_range = (min(min(a, b), c) > kSmallest) & (max(max(a, b), c) < kLargest);
    const V lo = min(min(c0, c1), min(c2, c3)), hi = max(max(c0, c1), max(c2, c3));
    return in_range & ((lo > error) | (hi < -error));
  }

  template <int First>
  static SELVEDGE_INLINE FilterVerdict run(const QueryBlock& q) {
    FilterVerdict verdict;
    for (int at = 0; at < QueryBlock::kSize; at += N) {
      const M apart = separated<First>(q, at);
      verdict.separated |= bits(apart) << at;
      if (all(apart)) continue;
      verdict.never_coplanar |= bits(never_coplanar<First>(q, at) & ~apart) << at;
    }
    return verdict;
  }
};

}  // namespace

FilterVerdict filter(const QueryBlock& block, bool edges) {
  return edges ? Kernel<2>::run<2>(block) : Kernel<2>::run<1>(block);
}

namespace {

/// Bound of the error of the Bernstein coefficients f(0), c1/3, c2/3, f(1) in the unit of
/// kCubicError: 6 terms with 8 roundings each for the outer ones, a third of 180 and one rounding
/// of at most 6 for the inner ones, and reserve.
constexpr double kBernsteinError = 96.0;
/// Bound of the error of a coefficient of n_i, of a constraint, and of its value on a box, in units
/// of u * M^2 with M = max(|X|, |Y|, |Z|). A product of two differences takes 3 roundings, a
/// coefficient of a cross product (4 products, halved) 4 * 5 / 2 = 10, the sum of three of them
/// 3 * 10 plus 2 roundings of at most 6; the value on a box is a mean of three coefficients of
/// at most 6 with at most 8 roundings: 48. In all 90, and reserve.
constexpr double kConstraintError = 128.0;
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
