// SPDX-License-Identifier: MIT
#include <selvedge/core/check.h>
#include <selvedge/narrowphase/detail/polynomial.h>
#include <selvedge/narrowphase/detail/polynomial_division.h>
#include <selvedge/narrowphase/detail/scaled.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace selvedge::narrowphase_detail {
namespace {

/// Number of bits by which one guess of the root in doubles shrinks a box: few enough, relative to
/// the rounding of doubles, that exact signs nearly always confirm the guess.
constexpr int kGuessedBits = 40;

/// The coefficients times one power of two; the largest is about 1.
template <class Int>
void to_doubles(const Polynomial<Int>& p, std::array<double, Polynomial<Int>::kMaxDegree + 1>& c) {
  int top = 0;
  for (int i = 0; i <= p.degree; ++i) top = std::max(top, p.c[i].bit_length());
  for (int i = 0; i <= p.degree; ++i) {
    int e = 0;
    const double f = p.c[i].mantissa(e);
    c[i] = std::ldexp(f, e - top);
  }
}

template <class Int>
Int power_of_two(int m) {
  return Int(1) << m;
}

template <class Int>
Int magnitude(const Int& a) {
  return a.sign() < 0 ? -a : a;
}

/// p restricted to the box, in the same form, times a power of two.
template <class Int>
Polynomial<Int> restrict_to(const Polynomial<Int>& p, const Box<Int>& box) {
  if (box.m == 0) return p;
  // With s the position in the box: 1 - t ~ a (1-s) + b s, t ~ c (1-s) + d s.
  const Int one = power_of_two<Int>(box.m), c = box.k, d = box.end(), a = one - c, b = one - d;
  Polynomial<Int> result, power;
  result.c[0] = p.c[p.degree];
  power.c[0] = Int(1);
  const auto times = [](const Polynomial<Int>& q, const Int& x, const Int& y) {
    Polynomial<Int> r;
    r.degree = q.degree + 1;
    for (int j = 0; j <= q.degree; ++j) {
      r.c[j].add_product(q.c[j], x);
      r.c[j + 1].add_product(q.c[j], y);
    }
    return r;
  };
  for (int i = p.degree; i-- > 0;) {
    result = times(result, c, d);
    power = times(power, a, b);
    for (int j = 0; j <= result.degree; ++j) result.c[j].add_product(power.c[j], p.c[i]);
  }
  return result;
}

/// +1 or -1 if all coefficients have that strict sign, so that the sign holds on the closed box.
template <class Int>
int strict_sign(const Polynomial<Int>& p) {
  const int s = p.c[0].sign();
  for (int i = 1; i <= p.degree; ++i)
    if (p.c[i].sign() != s) return 0;
  return s;
}

template <class Int>
int first_sign(const Polynomial<Int>& p) {
  for (int i = 0; i <= p.degree; ++i)
    if (!p.c[i].is_zero()) return p.c[i].sign();
  return 0;
}

/// The extremum of a cubic or quadratic with two sign changes, computed in doubles as a position in
/// the box. Accuracy does not matter.
template <class Int>
double guess_extremum(const Polynomial<Int>& local) {
  std::array<double, Polynomial<Int>::kMaxDegree + 1> c{};
  to_doubles(local, c);
  const int n = local.degree;
  const auto slope = [&](double s) {
    // d/ds of sum c[i] (1-s)^(n-i) s^i has the coefficients (i+1) c[i+1] - (n-i) c[i].
    double v = 0.0, power = 1.0;
    for (int i = n; i-- > 0;) {
      v = v * s + ((i + 1) * c[i + 1] - (n - i) * c[i]) * power;
      power *= 1.0 - s;
    }
    return v;
  };
  double lo = 0.0, hi = 1.0;
  const bool rising = slope(lo) < 0.0;
  constexpr int kSteps = 52;
  for (int step = 0; step < kSteps; ++step) {
    const double s = 0.5 * (lo + hi);
    ((slope(s) < 0.0) == rising ? lo : hi) = s;
  }
  return lo;
}

/// The part of the box, divided into 2^bits cells, from cell `from` to cell `to`.
template <class Int>
Box<Int> part_of(const Box<Int>& box, int bits, std::int64_t from, std::int64_t to) {
  return {(box.k << bits) + box.width * Int(from), box.width * Int(to - from), box.m + bits};
}

/// Separates two close roots by a point near the extremum between them, if the exact sign there
/// confirms it.
template <class Int>
bool separate_pair(const Polynomial<Int>& p, const Box<Int>& box, const Polynomial<Int>& local,
                   std::vector<Root<Int>>& roots) {
  constexpr std::int64_t kCells = std::int64_t{1} << kGuessedBits;
  const auto cell = static_cast<std::int64_t>(std::ldexp(guess_extremum(local), kGuessedBits));
  if (cell <= 0 || cell >= kCells) return false;
  Box<Int> left = part_of(box, kGuessedBits, 0, cell),
           right = part_of(box, kGuessedBits, cell, kCells);
  const int outer = first_sign(local);
  if (sign_at(p, right.k, right.m) != -outer) return false;
  roots.push_back(Root<Int>::isolated(p, std::move(left), outer));
  roots.push_back(Root<Int>::isolated(p, std::move(right), -outer));
  return true;
}

/// The zero of the second derivative of a cubic, as a position in the box. Accuracy does not
/// matter.
template <class Int>
double guess_inflection(const Polynomial<Int>& local) {
  std::array<double, Polynomial<Int>::kMaxDegree + 1> c{};
  to_doubles(local, c);
  const double at_lo = c[0] - 2.0 / 3.0 * c[1] + c[2] / 3.0;
  const double at_hi = c[1] / 3.0 - 2.0 / 3.0 * c[2] + c[3];
  const double place = at_lo / (at_lo - at_hi);
  return place > 0.0 && place < 1.0 ? place : 0.0;
}

/// Shrinks a box with several sign changes to two neighbouring cells of 2^kGuessedBits if all
/// changes are in them. The box then has no root elsewhere, because the parts of a box together
/// have at most as many changes as the whole.
template <class Int>
bool zoom(const Polynomial<Int>& p, const Polynomial<Int>& local, Box<Int>& box) {
  const int changes = sign_changes(local);
  const double place = changes == 2 ? guess_extremum(local) : guess_inflection(local);
  constexpr std::int64_t kCells = std::int64_t{1} << kGuessedBits;
  const std::int64_t cell = std::clamp<std::int64_t>(
      static_cast<std::int64_t>(std::ldexp(place, kGuessedBits)), 1, kCells - 1);
  Box<Int> cells = part_of(box, kGuessedBits, cell - 1, cell + 1);
  if (sign_changes(restrict_to(p, cells)) != changes) return false;
  box = std::move(cells);
  return true;
}

/// The magnitudes of the roots of sum of c[i] w^i, as powers of two, in ascending order: the slopes
/// of the upper hull of the points (i, log2 |c[i]|). The true ones differ by a few bits (Ostrowski
/// 1940). Returns their number.
template <class Int>
int root_scales(const Polynomial<Int>& p, std::array<int, Polynomial<Int>::kMaxDegree>& scales) {
  int count = 0;
  for (int i = 0; i < p.degree;) {
    int next = 0;
    double steepest = 0.0;
    for (int j = i + 1; j <= p.degree; ++j) {
      if (p.c[j].is_zero() || p.c[i].is_zero()) continue;
      const double slope = double(p.c[j].bit_length() - p.c[i].bit_length()) / (j - i);
      if (next == 0 || slope >= steepest) next = j, steepest = slope;
    }
    if (next == 0) {
      ++i;
      continue;
    }
    scales[count++] = -static_cast<int>(std::floor(steepest));
    i = next;
  }
  return count;
}

/// A cut of a box: into its first 2^-bits and the rest, or into its last 2^-bits and the rest.
struct Cut {
  int bits = 1;
  bool at_end = false;
};

/// A cut that parts roots of very different size, or from the ends of the box roots that are much
/// smaller than it; otherwise the middle.
template <class Int>
Cut cut_between_scales(const Polynomial<Int>& local) {
  constexpr int kFar = 10, kRoom = 5;  // bits
  std::array<int, Polynomial<Int>::kMaxDegree> scales{};
  const int n = root_scales(local, scales);
  if (n == 0) return {};
  if (scales[n - 1] < -kFar) return {-scales[n - 1] - kRoom, false};
  if (scales[0] > kFar) return {scales[0] - kRoom, true};
  for (int i = 0; i + 1 < n; ++i) {
    if (scales[i + 1] - scales[i] <= 2 * kFar) continue;
    const int middle = scales[i] + (scales[i + 1] - scales[i]) / 2;
    return {std::max(std::abs(middle), 1), middle > 0};
  }
  return {};
}

template <class Int>
std::array<Box<Int>, 2> parts_of(const Box<Int>& box, const Cut& cut) {
  const Int begin = box.k << cut.bits, rest = (box.width << cut.bits) - box.width;
  const int m = box.m + cut.bits;
  if (cut.at_end) return {Box<Int>{begin, rest, m}, Box<Int>{begin + rest, box.width, m}};
  return {Box<Int>{begin, box.width, m}, Box<Int>{begin + box.width, rest, m}};
}

/// Roots of a square-free p strictly inside a box, in ascending order. Terminates by the two-circle
/// theorem of Obreshkoff: small boxes have at most one sign change.
template <class Int>
void bisect_box(const Polynomial<Int>& p, const Box<Int>& whole, std::vector<Root<Int>>& roots) {
  struct Part {
    Box<Int> box;
    bool is_start = false;  ///< only the start of the box, which is a root
  };
  std::vector<Part> open{{whole}};
  while (!open.empty()) {
    Part part = std::move(open.back());
    open.pop_back();
    const Box<Int>& box = part.box;
    if (part.is_start) {
      roots.push_back(Root<Int>::rational(box.k, power_of_two<Int>(box.m) - box.k));
      continue;
    }
    const Polynomial<Int> local = restrict_to(p, box);
    const int changes = sign_changes(local);
    if (changes == 0) continue;
    if (changes == 1) {
      roots.push_back(Root<Int>::isolated(p, box, first_sign(local)));
      continue;
    }
    const Cut cut = cut_between_scales(local);
    if (cut.bits == 1 && changes == 2 && separate_pair(p, box, local, roots)) continue;
    if (cut.bits == 1 && zoom(p, local, part.box)) {
      open.push_back(std::move(part));
      continue;
    }
    const auto [left, right] = parts_of(box, cut);
    open.push_back({right});
    if (sign_at(p, right.k, right.m) == 0) open.push_back({right, true});
    open.push_back({left});
  }
}

template <class Int>
void push_if_positive(const Int& num, const Int& den, int multiplicity,
                      std::vector<Root<Int>>& roots) {
  if (num.sign() * den.sign() <= 0) return;
  roots.push_back(Root<Int>::rational(magnitude(num), magnitude(den)));
  roots.back().multiplicity = multiplicity;
}

/// Roots u > 0 of a quadratic or cubic p that has a multiple root: all of them are rational.
/// `common` is gcd(p, p').
template <class Int>
void multiple_roots(const Polynomial<Int>& p, const Polynomial<Int>& common,
                    std::vector<Root<Int>>& roots) {
  if (common.degree == 2) {  // (u - r)^3
    push_if_positive(-common.c[1], common.c[2] << 1, 3, roots);
    return;
  }
  // common = h1 u + h0 and p = (h1 u + h0)^2 (m1 u + m0) / w: the other root is -m0 / m1.
  const Int& h0 = common.c[0];
  const Int& h1 = common.c[1];
  push_if_positive(-h0, h1, 2, roots);
  if (p.degree < 3) return;
  const Int num = -(p.c[0] * h1 * h1);
  const Int den = p.c[3] * h0 * h0;
  const std::size_t n = roots.size();
  const bool had_double = h0.sign() * h1.sign() < 0;
  push_if_positive(num, den, 1, roots);
  if (!had_double || roots.size() == n) return;
  // Ascending: -h0 / h1 against num / den.
  if ((magnitude(num) * magnitude(h1) - magnitude(h0) * magnitude(den)).sign() < 0)
    std::swap(roots[n - 1], roots[n]);
}

/// The sign of c1² - 4 c0 c2.
template <class Int>
int discriminant_sign(const Polynomial<Int>& q) {
  const Scaled a = scaled(q.c[2]), b = scaled(q.c[1]), c = scaled(q.c[0]);
  if (const int s = certain_sign(std::array{b * b, -4.0 * (a * c)}); s != 0) return s;
  Int exact = q.c[1] * q.c[1];
  exact.add_product(q.c[0] << 2, q.c[2], true);
  return exact.sign();
}

/// The sign of the discriminant of a cubic a u³ + b u² + c u + d: positive if it has three real
/// roots, 0 if it has a multiple one.
template <class Int>
int cubic_discriminant_sign(const Polynomial<Int>& p) {
  {
    const Scaled a = scaled(p.c[3]), b = scaled(p.c[2]), c = scaled(p.c[1]), d = scaled(p.c[0]);
    const Scaled bb = b * b, cc = c * c, ad = a * d;
    if (const int s = certain_sign(std::array{bb * cc, -4.0 * (a * (cc * c)), -4.0 * (bb * (b * d)),
                                              -27.0 * (ad * ad), 18.0 * (ad * (b * c))});
        s != 0)
      return s;
  }
  // b²c² - 4ac³ - 4b³d - 27a²d² + 18abcd = (bc)² + 18 bc ad - 27 (ad)² - 4 (ac c² + bd b²)
  const Int &a = p.c[3], &b = p.c[2], &c = p.c[1], &d = p.c[0];
  const Int bc = b * c, ad = a * d;
  Int exact = bc * bc;
  exact.add_product(bc * Int(18), ad);
  exact.add_product(ad * Int(27), ad, true);
  exact.add_product((a * c) << 2, c * c, true);
  exact.add_product((b * d) << 2, b * b, true);
  return exact.sign();
}

/// Roots in the open interval (0, 1) of p with nonzero outer coefficients.
template <class Int>
void interior_roots(const Polynomial<Int>& p, std::vector<Root<Int>>& roots) {
  const int changes = sign_changes(p);
  if (changes == 0) return;
  if (p.degree == 1) {
    push_if_positive(-p.c[0], p.c[1], 1, roots);
    return;
  }
  if (changes == 1) {
    roots.push_back(Root<Int>::isolated(p, Box<Int>(), p.c[0].sign()));
    return;
  }
  // Roots u > 0 of p. If all roots are real, there are as many as sign changes (Descartes).
  const int discriminant = p.degree == 2 ? discriminant_sign(p) : cubic_discriminant_sign(p);
  if (discriminant == 0) {
    Polynomial<Int> slope = derivative(p);
    const Polynomial<Int> common = p.degree == 2 ? slope : remainder(p, slope);
    multiple_roots(p, common.is_zero() ? slope : common, roots);
  } else if (discriminant > 0) {
    bisect_box(p, Box<Int>(), roots);
  } else if (changes == 3) {  // the other two roots are not real
    roots.push_back(Root<Int>::isolated(p, Box<Int>(), p.c[0].sign()));
  }
}

double ordered_double(std::int64_t bits) { return std::bit_cast<double>(bits); }
std::int64_t ordered_bits(double x) { return std::bit_cast<std::int64_t>(x); }

/// x >= 0 as k / 2^m.
template <class Int>
void to_dyadic(double x, Int& k, int& m) {
  int e = 0;
  std::frexp(x, &e);
  constexpr int kMantissaBits = 53;
  m = std::max(kMantissaBits - e, 0);
  m = std::min(m, 1074);
  k = Int::from_double(x, -m);
}

template <class Int>
int sign_at_double(const Polynomial<Int>& p, double t) {
  Int k;
  int m = 0;
  to_dyadic(t, k, m);
  return sign_at(p, k, m);
}

/// The largest double not above k / 2^m, and whether it equals that number.
template <class Int>
double floor_of_dyadic(const Int& k, int m, bool& exact) {
  exact = k.is_zero();
  if (exact) return 0.0;
  int e = 0;
  const double f = k.mantissa(e);
  const double x = std::ldexp(f, e - m);
  if (x == 0.0) return 0.0;
  Int kx;
  int mx = 0;
  to_dyadic(x, kx, mx);
  // ldexp rounds only where the result is subnormal.
  const Int excess = (kx << std::max(m - mx, 0)) - (k << std::max(mx - m, 0));
  exact = excess.is_zero();
  return excess.sign() > 0 ? std::nextafter(x, 0.0) : x;
}

}  // namespace

template <class Int>
bool Polynomial<Int>::is_zero() const {
  for (int i = 0; i <= degree; ++i)
    if (!c[i].is_zero()) return false;
  return true;
}

template <class Int>
Polynomial<Int> operator+(const Polynomial<Int>& a, const Polynomial<Int>& b) {
  Polynomial<Int> r;
  r.degree = a.degree;
  for (int i = 0; i <= a.degree; ++i) r.c[i] = a.c[i] + b.c[i];
  return r;
}

template <class Int>
Polynomial<Int> operator-(const Polynomial<Int>& a, const Polynomial<Int>& b) {
  Polynomial<Int> r;
  r.degree = a.degree;
  for (int i = 0; i <= a.degree; ++i) r.c[i] = a.c[i] - b.c[i];
  return r;
}

template <class Int>
Polynomial<Int> operator*(const Polynomial<Int>& a, const Polynomial<Int>& b) {
  Polynomial<Int> r;
  r.degree = a.degree + b.degree;
  add_product(r, a, b);
  return r;
}

template <class Int>
void add_product(Polynomial<Int>& r, const Polynomial<Int>& a, const Polynomial<Int>& b,
                 bool negate) {
  SELVEDGE_ASSERT(r.degree == a.degree + b.degree && r.degree <= Polynomial<Int>::kMaxDegree);
  for (int i = 0; i <= a.degree; ++i)
    for (int j = 0; j <= b.degree; ++j) r.c[i + j].add_product(a.c[i], b.c[j], negate);
}

namespace {

/// The sign of the sum of c[i] num^i den^(n-i) if 106 bits show it, else 0. For short numbers the
/// exact sum is as quick.
template <class Int>
int sign_if_certain(const Polynomial<Int>& p, const Int& num, const Int& den) {
  constexpr int kLong = 512;  // bits
  if (p.c[0].bit_length() + p.degree * std::max(num.bit_length(), den.bit_length()) < kLong)
    return 0;
  const Scaled x = scaled(num), y = scaled(den);
  std::array<Scaled, Polynomial<Int>::kMaxDegree + 1> terms;
  Scaled power{{1.0, 0.0}, 0};
  for (int i = 0; i <= p.degree; ++i, power = power * x) terms[i] = scaled(p.c[i]) * power;
  power = {{1.0, 0.0}, 0};
  for (int i = p.degree; i >= 0; --i, power = power * y) terms[i] = terms[i] * power;
  return certain_sign(terms);
}

}  // namespace

template <class Int>
int sign_at(const Polynomial<Int>& p, const Int& k, int m) {
  if (k.is_zero()) return p.c[0].sign();
  const Int rest = power_of_two<Int>(m) - k;
  if (rest.is_zero()) return p.c[p.degree].sign();
  if (const int s = sign_if_certain(p, k, rest); s != 0) return s;
  // Homogeneous Horner scheme: sum of c[i] k^i rest^(n-i).
  Int value = p.c[p.degree];
  Int power(1);
  for (int i = p.degree; i-- > 0;) {
    power = power * rest;
    value = value * k;
    value.add_product(p.c[i], power);
  }
  return value.sign();
}

template <class Int>
Root<Int> Root<Int>::rational(Int num, Int den) {
  Root<Int> r;
  r.rational_ = true;
  r.num_ = std::move(num);
  r.den_ = std::move(den);
  return r;
}

template <class Int>
Root<Int> Root<Int>::isolated(Polynomial<Int> p, Box<Int> box, int sign_lo) {
  Root<Int> r;
  r.rational_ = false;
  r.p_ = std::move(p);
  r.box_ = std::move(box);
  r.sign_lo_ = sign_lo;
  return r;
}

template <class Int>
Root<Int> Root<Int>::between_doubles(Polynomial<Int> p, double lo, double hi, int sign_lo) {
  Int k_lo, k_hi;
  int m_lo = 0, m_hi = 0;
  to_dyadic(lo, k_lo, m_lo);
  to_dyadic(hi, k_hi, m_hi);
  const int m = std::max(m_lo, m_hi);
  k_lo = k_lo << (m - m_lo);
  k_hi = k_hi << (m - m_hi);
  return isolated(std::move(p), {k_lo, k_hi - k_lo, m}, sign_lo);
}

template <class Int>
Root<Int> Root<Int>::near_double(const Polynomial<Int>& p, double lo, double t, double hi,
                                 int sign_lo) {
  // Steps of 1, 32, 1024 ... doubles towards the root.
  constexpr int kStepBits = 5, kLargestStep = 40;
  const int sign = sign_at_double(p, t);
  if (sign == 0) return at_double(t);
  const std::int64_t way = sign == sign_lo ? 1 : -1;
  double& near = way > 0 ? lo : hi;
  double& far = way > 0 ? hi : lo;
  near = t;
  for (int bits = 0; bits <= kLargestStep; bits += kStepBits) {
    const double x = ordered_double(
        std::max<std::int64_t>(ordered_bits(t) + way * (std::int64_t{1} << bits), 0));
    if (way > 0 ? x >= far : x <= far) break;
    const int s = sign_at_double(p, x);
    if (s == 0) return at_double(x);
    (s == sign ? near : far) = x;
    if (s != sign) break;
  }
  return between_doubles(p, lo, hi, sign_lo);
}

template <class Int>
Root<Int> Root<Int>::at_double(double t) {
  Int k;
  int m = 0;
  to_dyadic(t, k, m);
  return rational(k, power_of_two<Int>(m) - k);
}

template <class Int>
void Root<Int>::become(Int num, Int den) {
  const int kept = multiplicity;
  *this = rational(std::move(num), std::move(den));
  multiplicity = kept;
}

/// Makes the root the start of this cell of the box, divided into 2^bits cells.
template <class Int>
void Root<Int>::become_border(std::int64_t cell, int bits) {
  Int k = (box_.k << bits) + box_.width * Int(cell);
  Int rest = power_of_two<Int>(box_.m + bits) - k;
  become(std::move(k), std::move(rest));
}

template <class Int>
void Root<Int>::bisect() {
  Box<Int> right = part_of(box_, 1, 1, 2);
  const int s = sign_at(p_, right.k, right.m);
  if (s == 0)
    become_border(1, 1);
  else
    box_ = s == sign_lo_ ? std::move(right) : part_of(box_, 1, 0, 1);
}

/// The root in doubles, as a position in the box. Accuracy does not matter, because exact signs
/// confirm every use.
template <class Int>
double Root<Int>::guess() const {
  const Polynomial<Int> local = restrict_to(p_, box_);
  std::array<double, Polynomial<Int>::kMaxDegree + 1> c{};
  to_doubles(local, c);
  const auto value = [&](double s) {
    double v = c[local.degree], power = 1.0;
    for (int i = local.degree; i-- > 0;) {
      power *= 1.0 - s;
      v = v * s + c[i] * power;
    }
    return v;
  };
  // Illinois variant of the false position method [Dowell, Jarratt 1971]: bracketed and
  // superlinear.
  double lo = 0.0, hi = 1.0, f_lo = c[0], f_hi = c[local.degree];
  if (f_lo == 0.0 || f_hi == 0.0 || (f_lo < 0.0) == (f_hi < 0.0)) return 0.5;
  constexpr int kSteps = 60;
  double s = 0.5;
  for (int step = 0; step < kSteps; ++step) {
    const double next = lo + (hi - lo) * (f_lo / (f_lo - f_hi));
    if (!(next > lo && next < hi) || next == s) break;
    s = next;
    const double f = value(s);
    if (f == 0.0) break;
    if ((f < 0.0) == (f_lo < 0.0)) {
      lo = s, f_lo = f, f_hi *= 0.5;
    } else {
      hi = s, f_hi = f, f_lo *= 0.5;
    }
  }
  return s;
}

/// Shrinks the box by 2^-kGuessedBits around the root computed in doubles if exact signs confirm
/// it; otherwise halves it.
template <class Int>
void Root<Int>::narrow() {
  // The root is looked for on both sides of the nearest cell border, since it may be a number with
  // few bits, or lie much nearer to one than a cell is wide.
  constexpr std::int64_t kCells = std::int64_t{1} << kGuessedBits;
  const std::int64_t border = std::llround(std::ldexp(guess(), kGuessedBits));
  if (border < 0 || border > kCells) return bisect();
  const auto sign_at_border = [&](std::int64_t cell) {
    if (cell == 0) return sign_lo_;  // at the ends of the box the sides are known
    if (cell == kCells) return -sign_lo_;
    return sign_at(p_, (box_.k << kGuessedBits) + box_.width * Int(cell), box_.m + kGuessedBits);
  };
  const int sign = sign_at_border(border);
  if (sign == 0) return become_border(border, kGuessedBits);
  const bool is_right = sign == sign_lo_;
  if (sign_at_border(is_right ? border + 1 : border - 1) != -sign) return bisect();
  box_ =
      part_of(box_, kGuessedBits, is_right ? border : border - 1, is_right ? border + 1 : border);
}

template <class Int>
int Root<Int>::sign_if_clear(const Polynomial<Int>& q) const {
  if (rational_) {
    if (num_.is_zero()) return q.c[0].sign();
    if (den_.is_zero()) return q.c[q.degree].sign();
    if (const int s = sign_if_certain(q, num_, den_); s != 0) return s;
    Int value = q.c[q.degree];
    Int power(1);
    for (int i = q.degree; i-- > 0;) {
      power = power * den_;
      value = value * num_ + q.c[i] * power;
    }
    return value.sign();
  }
  const int s = strict_sign(q);
  return s != 0 || q.degree != 2 ? s : sign_in_doubles(q);
}

/// The Bernstein coefficients of q on the box, from values of the polar form. With the largest
/// coefficient of q as the unit, the others and the ends of the box are off by 2^-52, which changes
/// a coefficient by less than 16 * 2^-52; its own roundings are fewer.
template <class Int>
int Root<Int>::sign_in_doubles(const Polynomial<Int>& q) const {
  constexpr double kError = 0x1p-46;
  std::array<double, Polynomial<Int>::kMaxDegree + 1> c{};
  to_doubles(q, c);
  const auto time = [&](const Int& k) {
    int exponent = 0;
    const double mantissa = k.mantissa(exponent);
    return std::ldexp(mantissa, exponent - box_.m);
  };
  const double lo = time(box_.k), hi = time(box_.end());
  const auto polar = [&](double s, double t) {
    return (1.0 - s) * (1.0 - t) * c[0] + 0.5 * ((1.0 - s) * t + s * (1.0 - t)) * c[1] +
           s * t * c[2];
  };
  const double a = polar(lo, lo), b = polar(lo, hi), d = polar(hi, hi);
  return std::min({a, b, d}) > kError ? 1 : (std::max({a, b, d}) < -kError ? -1 : 0);
}

/// The sign of a root b of q minus the root a of p, where `sign_p` is the sign of p at b, and `lo`
/// and `hi` those of b minus the ends of the box: between them, a is where p changes its sign.
template <class Int>
int Root<Int>::side(int sign_p, int lo, int hi) const {
  if (lo <= 0) return -1;
  if (hi >= 0) return 1;
  return sign_p == sign_lo_ ? -1 : (sign_p == 0 ? 0 : 1);
}

namespace {

/// The real roots of a polynomial of degree 2 in u with two different ones, without computing them.
template <class Int>
class TwoRoots {
 public:
  explicit TwoRoots(const Polynomial<Int>& q) : q_(q), lead_(q.c[2].sign()) {}

  /// The signs of the smaller and of the larger root minus num / den, where den >= 0; 1/0 is
  /// infinite.
  std::array<int, 2> minus(const Int& num, const Int& den) const {
    if (den.is_zero()) return {-1, -1};
    const int sign = value_sign(num, den) * lead_;
    if (sign < 0) return {-1, 1};
    // The half sum of the roots, -c1 / (2 c2), minus num / den.
    const Int twice = q_.c[2] << 1;
    const int half = -(q_.c[1] * den + twice * num).sign() * lead_;
    const int other = sign == 0 ? 0 : half;
    return half > 0 ? std::array{other, 1} : std::array{-1, other};
  }

 private:
  int value_sign(const Int& num, const Int& den) const {
    if (const int s = sign_if_certain(q_, num, den); s != 0) return s;
    Int value = q_.c[2] * num + q_.c[1] * den;
    value = value * num;
    value.add_product(q_.c[0], den * den);
    return value.sign();
  }

  const Polynomial<Int>& q_;
  int lead_;
};

/// num / den with den >= 0 as the value u of the time k / 2^m.
template <class Int>
std::array<Int, 2> as_quotient(const Int& k, int m) {
  return {k, power_of_two<Int>(m) - k};
}

}  // namespace

/// The exact sign of a linear q. It is that of c1 (a - b) for its root b = -c0 / c1.
template <class Int>
int Root<Int>::sign_of_linear(const Polynomial<Int>& q) {
  const int lead = q.c[1].sign();
  if (q.c[0].sign() * lead >= 0) return lead;  // b <= 0 < a
  const auto compared = [&](const Int& k) {    // b minus the end of the box
    const auto [num, den] = as_quotient(k, box_.m);
    return -lead * (q.c[1] * num + q.c[0] * den).sign();
  };
  Root<Int> b = rational(magnitude(q.c[0]), magnitude(q.c[1]));
  const int lo = compared(box_.k), hi = compared(box_.end());
  const int from_a = side(lo > 0 && hi < 0 ? b.sign_if_clear(p_) : 0, lo, hi);
  if (from_a == 0) become(std::move(b.num_), std::move(b.den_));
  return -from_a * lead;
}

/// The exact sign of q at the root a of p without narrowing the box, which would take as many steps
/// as p and q have bits if they nearly have a common root. With r = p mod q, which is at most
/// linear, p has the sign of r at the roots b of q; and the order of b and the root of r, a
/// rational number, follows from the sign of q there. The signs of p say on which side of a each b
/// is.
template <class Int>
int Root<Int>::sign_by_remainder(Polynomial<Int> q) {
  drop_leading_zeros(q);
  if (q.degree == 0) return q.c[0].sign();
  if (q.degree == 1) return sign_of_linear(q);
  const int lead = q.c[2].sign();
  const int discriminant = discriminant_sign(q);
  if (discriminant < 0) return lead;
  if (discriminant == 0) {  // q is c2 times the square of a linear factor
    Polynomial<Int> factor;
    factor.degree = 1;
    factor.c[0] = q.c[1];
    factor.c[1] = q.c[2] << 1;
    return sign_of_linear(factor) == 0 ? 0 : lead;
  }
  const TwoRoots<Int> roots(q);
  const auto [lo_num, lo_den] = as_quotient(box_.k, box_.m);
  const auto [hi_num, hi_den] = as_quotient(box_.end(), box_.m);
  const std::array<int, 2> lo = roots.minus(lo_num, lo_den), hi = roots.minus(hi_num, hi_den);
  const Polynomial<Int> r = remainder(p_, q);
  std::array<int, 2> sign_p = {r.c[0].sign(), r.c[0].sign()};
  if (r.degree == 1) {
    const bool flips = r.c[1].sign() < 0;  // den >= 0
    const std::array<int, 2> from = roots.minus(flips ? r.c[0] : -r.c[0], flips ? -r.c[1] : r.c[1]);
    for (int i = 0; i < 2; ++i) sign_p[i] = from[i] * r.c[1].sign();
  }
  int sign = lead;
  for (int i = 0; i < 2; ++i) {
    const int from_a = side(sign_p[i], lo[i], hi[i]);
    if (from_a == 0 && r.degree == 1) become(magnitude(r.c[0]), magnitude(r.c[1]));
    sign *= -from_a;
  }
  return sign;
}

template <class Int>
int Root<Int>::sign(const Polynomial<Int>& q) {
  if (q.is_zero()) return 0;
  if (rational_) return sign_if_clear(q);
  if (const int s = sign_if_clear(q); s != 0) return s;
  if (box_.m < kGuessedBits) {
    narrow();
    if (rational_) return sign_if_clear(q);
    if (const int s = sign_if_clear(q); s != 0) return s;
  }
  if (const int s = strict_sign(restrict_to(q, box_)); s != 0) return s;
  return sign_by_remainder(q);
}

/// The rational root, rounded a few times.
template <class Int>
double Root<Int>::quotient() const {
  int exponent = 0, exponent_of_sum = 0;
  const double mantissa = num_.mantissa(exponent);
  const double mantissa_of_sum = (num_ + den_).mantissa(exponent_of_sum);
  return std::ldexp(mantissa / mantissa_of_sum, exponent - exponent_of_sum);
}

template <class Int>
bool Root<Int>::is_quotient(double t) const {
  Int k;
  int m = 0;
  to_dyadic(t, k, m);
  return (k * (num_ + den_) - (num_ << m)).is_zero();
}

template <class Int>
double Root<Int>::floor(bool& exact) const {
  if (!rational_) {
    Root narrower = *this;
    if (box_.m == 0) narrower.narrow();
    if (!narrower.rational_) return narrower.floor_in_box(exact);
    return narrower.floor(exact);
  }
  exact = true;
  if (num_.is_zero()) return 0.0;
  if (den_.is_zero()) return 1.0;
  if (const double t = quotient(); is_quotient(t)) return t;
  Polynomial<Int> line;
  line.degree = 1;
  line.c = {-num_, den_};
  return isolated(line, Box<Int>(), -1).floor_in_box(exact);
}

template <class Int>
double Root<Int>::floor_in_box(bool& exact) const {
  exact = false;
  bool end_is_double = false;
  double lo = floor_of_dyadic(box_.k, box_.m, end_is_double);
  const double start = lo;
  double hi = floor_of_dyadic(box_.end(), box_.m, end_is_double);
  if (!end_is_double) hi = std::nextafter(hi, 2.0);
  // Invariant: lo < root < hi. Signs are evaluated strictly inside the box, where they show on
  // which side the root is.
  const auto inside = [&](double x) { return x > lo && x < hi; };
  const auto split = [&](double x) {
    const int s = sign_at_double(p_, x);
    if (s == 0) {
      exact = true;
      lo = x;
      return;
    }
    (s == sign_lo_ ? lo : hi) = x;
  };
  int exponent = 0;
  const double width = std::ldexp(box_.width.mantissa(exponent), exponent - box_.m);
  const double near = std::min(start + width * guess(), 1.0);
  const std::int64_t bits = ordered_bits(near);
  for (const std::int64_t step : {0, 1, 16, 4096}) {
    for (const std::int64_t x : {bits - step, bits + step})
      if (x >= 0 && inside(ordered_double(x)) && !exact) split(ordered_double(x));
  }
  while (!exact && ordered_bits(hi) - ordered_bits(lo) > 1)
    split(ordered_double(ordered_bits(lo) + (ordered_bits(hi) - ordered_bits(lo)) / 2));
  return lo;
}

template <class Int>
void isolate_roots(const Polynomial<Int>& p, std::vector<Root<Int>>& roots) {
  SELVEDGE_ASSERT(!p.is_zero());
  Polynomial<Int> inner = p;
  drop_content(inner);
  int zeros = 0;
  while (inner.c[zeros].is_zero()) ++zeros;
  for (int i = 0; i + zeros <= inner.degree; ++i) inner.c[i] = inner.c[i + zeros];
  inner.degree -= zeros;
  const int before = inner.degree;
  drop_leading_zeros(inner);
  for (int i = inner.degree + 1; i <= Polynomial<Int>::kMaxDegree; ++i) inner.c[i] = Int();
  if (zeros > 0) {
    roots.push_back(Root<Int>::rational(Int(), Int(1)));
    roots.back().multiplicity = zeros;
  }
  if (inner.degree > 0) interior_roots(inner, roots);
  if (before > inner.degree) {
    roots.push_back(Root<Int>::rational(Int(1), Int()));
    roots.back().multiplicity = before - inner.degree;
  }
}

#define SELVEDGE_INSTANTIATE(Int)                                                             \
  template struct Polynomial<Int>;                                                            \
  template class Root<Int>;                                                                   \
  template Polynomial<Int> operator+(const Polynomial<Int>&, const Polynomial<Int>&);         \
  template Polynomial<Int> operator-(const Polynomial<Int>&, const Polynomial<Int>&);         \
  template Polynomial<Int> operator*(const Polynomial<Int>&, const Polynomial<Int>&);         \
  template void add_product(Polynomial<Int>&, const Polynomial<Int>&, const Polynomial<Int>&, \
                            bool);                                                            \
  template int sign_at(const Polynomial<Int>&, const Int&, int);                              \
  template void isolate_roots(const Polynomial<Int>&, std::vector<Root<Int>>&);
SELVEDGE_INSTANTIATE(BigInt)
SELVEDGE_INSTANTIATE(SmallInt)
#undef SELVEDGE_INSTANTIATE

}  // namespace selvedge::narrowphase_detail
