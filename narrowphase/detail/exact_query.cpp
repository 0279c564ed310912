// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/detail/exact_query.h>
#include <selvedge/narrowphase/detail/in_plane.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

// The four vertices move as polynomials of degree 1 with integer coefficients. Write, all as
// vectors that depend on t,
//   point against triangle:  X = b - a,    Y = c - a,    Z = p - a,
//   edge against edge:       X = a1 - a0,  Y = b1 - b0,  Z = b0 - a0,
// n = X x Y and f = n . Z. A contact at t needs coplanar vertices, f(t) = 0.
//
// Where n(t) is not the null vector, let n_i be a component that is not zero. In the common plane
// all cross products of X, Y and Z are multiples of n, so that component i alone carries their
// signs and ratios. With g = X x Z, h = Z x Y the point is a + (h_i/n_i) X + (g_i/n_i) Y, and it
// lies in the closed triangle iff h_i/n_i, g_i/n_i and 1 - h_i/n_i - g_i/n_i are not negative. With
// h = Z x Y and g = Z x X the lines of two edges meet at a0 + (h_i/n_i) X = b0 + (g_i/n_i) Y, on
// both closed edges iff h_i/n_i and g_i/n_i lie in [0, 1]. So every test is the sign of a product
// of quadratics, where the dot products with n would be of degree four.
//
// Where n(t) = 0 the triangle is a segment or a point, the union of its closed edges, and two edges
// are parallel or degenerate: there is a contact iff an end point of one segment lies on another
// one. q lies on the closed segment (r, s) iff (s-r) x (q-r) = 0 and (q-r) . (q-s) <= 0.

namespace selvedge::detail {

namespace {

template <class Int>
using PolyVec = std::array<Polynomial<Int>, 3>;

template <class Int>
PolyVec<Int> operator-(const PolyVec<Int>& a, const PolyVec<Int>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// a b - c d, all of equal degree.
template <class Int>
Polynomial<Int> determinant(const Polynomial<Int>& a, const Polynomial<Int>& b,
                            const Polynomial<Int>& c, const Polynomial<Int>& d) {
  Polynomial<Int> r;
  r.degree = a.degree + b.degree;
  add_product(r, a, b);
  add_product(r, c, d, true);
  return r;
}

template <class Int>
PolyVec<Int> cross(const PolyVec<Int>& a, const PolyVec<Int>& b) {
  return {determinant(a[1], b[2], a[2], b[1]), determinant(a[2], b[0], a[0], b[2]),
          determinant(a[0], b[1], a[1], b[0])};
}

template <class Int>
Polynomial<Int> dot(const PolyVec<Int>& a, const PolyVec<Int>& b) {
  Polynomial<Int> r;
  r.degree = a[0].degree + b[0].degree;
  for (int i = 0; i < 3; ++i) add_product(r, a[i], b[i]);
  return r;
}

template <class Int>
bool is_zero(const PolyVec<Int>& a) {
  return a[0].is_zero() && a[1].is_zero() && a[2].is_zero();
}

/// Whether a path, of degree 1, ends where it starts.
template <class Int>
bool is_constant(const PolyVec<Int>& a) {
  for (const Polynomial<Int>& p : a)
    if (!(p.c[1] - p.c[0]).is_zero()) return false;
  return true;
}

/// The coarsest power-of-two grid that represents all coordinates exactly.
struct Grid {
  int exponent = std::numeric_limits<int>::max();
  int bits = 0;  ///< number of bits of the largest coordinate on it
};

Grid grid_of(const Query& query) {
  Grid grid;
  double largest = 0.0;
  for (const auto* x : {&query.x_t0, &query.x_t1})
    for (const Vec3& v : *x)
      for (int i = 0; i < 3; ++i) {
        if (v[i] == 0.0) continue;
        grid.exponent = std::min(grid.exponent, lowest_bit(v[i]));
        largest = std::max(largest, std::abs(v[i]));
      }
  if (largest > 0.0) grid.bits = std::ilogb(largest) + 1 - grid.exponent;
  return grid;
}

/// The paths of the vertices as integers on the grid.
template <class Int>
std::array<PolyVec<Int>, 4> integer_paths(const Query& query, int exponent) {
  std::array<PolyVec<Int>, 4> paths;
  for (int k = 0; k < 4; ++k) {
    for (int i = 0; i < 3; ++i) {
      paths[k][i].degree = 1;
      paths[k][i].c[0] = Int::from_double(query.x_t0[k][i], exponent);
      paths[k][i].c[1] = Int::from_double(query.x_t1[k][i], exponent);
    }
  }
  return paths;
}

template <class Int>
class ExactQuery {
 public:
  ExactQuery(const Query& query, int exponent)
      : query_(query),
        edges_(query.kind == ContactKind::edge_edge),
        x_(integer_paths<Int>(query, exponent)) {
    const int base = edges_ ? 0 : 1;
    X_ = x_[edges_ ? 1 : 2] - x_[base];
    Y_ = edges_ ? x_[3] - x_[2] : x_[3] - x_[1];
    Z_ = edges_ ? x_[2] - x_[0] : x_[0] - x_[1];
    n_ = cross(X_, Y_);
    f_ = dot(n_, Z_);
  }

  const Polynomial<Int>& cubic() const { return f_; }

  bool first_contact(const FilterKernel& kernel, double& toi) {
    return f_.is_zero() ? first_coplanar_contact(kernel, toi) : first_root_in_contact(toi);
  }

  /// Whether the primitives touch at a root of f.
  bool touches(Root<Int>& root) {
    int component = -1, sign = 0;
    for (int i = 0; i < 3 && sign == 0; ++i) {
      sign = root.sign_if_clear(n_[i]);
      component = i;
    }
    for (int i = 0; i < 3 && sign == 0; ++i) {
      sign = root.sign(n_[i]);
      component = i;
    }
    if (sign == 0) {
      for (const SegmentTest& test : segment_tests())
        if (on_segment(root, test)) return true;
      return false;
    }
    const std::array<Polynomial<Int>, 4>& tests = constraints(component);
    // Most roots clearly violate one constraint, so the cheap test runs on all of them before the
    // thorough one.
    for (const Polynomial<Int>& p : tests)
      if (root.sign_if_clear(p) * sign < 0) return false;
    for (const Polynomial<Int>& p : tests)
      if (root.sign(p) * sign < 0) return false;
    return true;
  }

 private:
  bool first_root_in_contact(double& toi) {
    std::vector<Root<Int>> roots;
    isolate_roots(f_, roots);
    for (Root<Int>& root : roots) {
      if (!touches(root)) continue;
      bool exact = false;
      toi = root.floor(exact);
      return true;
    }
    return false;
  }

  /// f = 0 at all times. Between two neighbouring roots of all polynomials that decide, no sign
  /// changes, and the set of contact times is closed; so it begins at 0 or at one of the roots. If
  /// n is not identically zero, these are the roots of one component i of n that is not identically
  /// zero (they include the times where n = 0, and those where component i vanishes alone) and of
  /// the constraints made with component i; otherwise those of the segment tests.
  ///
  /// If stage C decides the contacts in the plane, none of these roots is needed.
  bool first_coplanar_contact(const FilterKernel& kernel, double& toi) {
    toi = 0.0;
    Root<Int> start = Root<Int>::rational(Int(), Int(1));
    if (touches(start)) return true;
    if (is_constant(X_) && is_constant(Y_) && is_constant(Z_)) return false;  // nothing changes
    const ContactDecision in_plane = first_contact_in_plane(kernel, query_, toi);
    if (in_plane != ContactDecision::open) return in_plane == ContactDecision::yes;
    std::vector<Root<Int>> roots;
    const auto add = [&](const Polynomial<Int>& p) {
      if (!p.is_zero()) isolate_roots(p, roots);
    };
    if (!is_zero(n_)) {
      const int i = !n_[0].is_zero() ? 0 : (!n_[1].is_zero() ? 1 : 2);
      add(n_[i]);
      for (const Polynomial<Int>& p : constraints(i)) add(p);
    } else {
      for (const SegmentTest& test : segment_tests()) {
        for (const Polynomial<Int>& p : test.line) add(p);
        add(test.span);
      }
    }
    toi = first_touching(roots);
    return toi <= 1.0;
  }

  /// The largest double not above the first of the roots at which the primitives touch; above 1 if
  /// they touch at none. The roots that may be first come first, and those that cannot be are left
  /// out.
  double first_touching(std::vector<Root<Int>>& roots) {
    struct Start {
      double bound;
      Root<Int>* root;
    };
    std::vector<Start> starts;
    for (Root<Int>& root : roots) starts.push_back({root.lower_bound(), &root});
    std::stable_sort(starts.begin(), starts.end(),
                     [](const Start& a, const Start& b) { return a.bound < b.bound; });
    double first = 2.0;
    for (const auto& [bound, root] : starts) {
      if (bound >= first) break;
      if (!touches(*root)) continue;
      bool exact = false;
      first = std::min(first, root->floor(exact));
    }
    return first;
  }

  struct SegmentTest {
    PolyVec<Int> line;
    Polynomial<Int> span;
  };

  static bool on_segment(Root<Int>& root, const SegmentTest& test) {
    for (const Polynomial<Int>& p : test.line)
      if (root.sign_if_clear(p) != 0) return false;
    if (root.sign_if_clear(test.span) > 0) return false;
    for (const Polynomial<Int>& p : test.line)
      if (root.sign(p) != 0) return false;
    return root.sign(test.span) <= 0;
  }

  /// Polynomials that, times the sign of n_i, must not be negative.
  const std::array<Polynomial<Int>, 4>& constraints(int i) {
    if (constrained_ == i) return constraints_;
    constrained_ = i;
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const auto component = [&](const PolyVec<Int>& a, const PolyVec<Int>& b) {
      return determinant(a[j], b[k], a[k], b[j]);
    };
    const Polynomial<Int> h = component(Z_, Y_);
    if (edges_) {
      const Polynomial<Int> g = component(Z_, X_);
      constraints_ = {h, n_[i] - h, g, n_[i] - g};
    } else {
      const Polynomial<Int> g = component(X_, Z_);
      const Polynomial<Int> rest = n_[i] - h - g;
      constraints_ = {h, g, rest, rest};
    }
    return constraints_;
  }

  const std::vector<SegmentTest>& segment_tests() {
    if (!segment_tests_.empty()) return segment_tests_;
    const auto add = [&](int q, int r, int s) {
      segment_tests_.push_back(
          {cross(x_[s] - x_[r], x_[q] - x_[r]), dot(x_[q] - x_[r], x_[q] - x_[s])});
    };
    if (edges_) {
      add(0, 2, 3), add(1, 2, 3), add(2, 0, 1), add(3, 0, 1);
    } else {
      add(0, 1, 2), add(0, 2, 3), add(0, 3, 1);
    }
    return segment_tests_;
  }

  const Query& query_;
  bool edges_;
  std::array<PolyVec<Int>, 4> x_;
  PolyVec<Int> X_, Y_, Z_, n_;
  Polynomial<Int> f_;
  int constrained_ = -1;
  std::array<Polynomial<Int>, 4> constraints_;
  std::vector<SegmentTest> segment_tests_;
};

/// Coordinates with more bits use BigInt at once, because their roots seldom fit into SmallInt.
constexpr int kSmallBits = 64;

/// Calls decide(ExactQuery) with integers of a fixed width, or of any width where those do not fit.
template <class Decide>
bool with_integers_that_fit(const Query& query, Decide decide) {
  const Grid grid = grid_of(query);
  if (grid.bits <= kSmallBits) {
    try {
      ExactQuery<SmallInt> exact(query, grid.exponent);
      return decide(exact);
    } catch (const DoesNotFit&) {  // rare: a root that needs many bits
    }
  }
  ExactQuery<BigInt> exact(query, grid.exponent);
  return decide(exact);
}

}  // namespace

bool collides_exactly(const FilterKernel& kernel, const Query& query, double& toi) {
  return with_integers_that_fit(
      query, [&]<class Int>(ExactQuery<Int>& exact) { return exact.first_contact(kernel, toi); });
}

bool touches_exactly(const Query& query, IsolatedRoot& root) {
  return with_integers_that_fit(query, [&]<class Int>(ExactQuery<Int>& exact) {
    const auto& [lo, hi, floor, sign_lo] = root;
    const bool is_narrow = floor == lo;
    Root<Int> found = is_narrow ? Root<Int>::between_doubles(exact.cubic(), lo, hi, sign_lo)
                                : Root<Int>::near_double(exact.cubic(), lo, floor, hi, sign_lo);
    if (!exact.touches(found)) return false;
    bool is_double = false;
    if (!is_narrow) root.floor = found.floor(is_double);
    return true;
  });
}

Polynomial<BigInt> coplanarity_cubic(const Query& query) {
  return ExactQuery<BigInt>(query, grid_of(query).exponent).cubic();
}

}  // namespace selvedge::detail
