// SPDX-License-Identifier: MIT
#include <selvedge/core/check.h>
#include <selvedge/narrowphase/detail/polynomial.h>
#include <selvedge/narrowphase/detail/polynomial_division.h>

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
    double v = 0.0;
    for (int i = 0; i < n; ++i)
      v += ((i + 1) * c[i + 1] - (n - i) * c[i]) * std::pow(1.0 - s, n - 1 - i) * std::pow(s, i);
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

/// Roots of a square-free p strictly inside a box, in ascending order. Terminates by the two-circle
/// theorem of Obreshkoff: small boxes have at most one sign change. Roots of very different size
/// take thousands of halvings, hence no recursion.
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
    if (changes == 2 && separate_pair(p, box, local, roots)) continue;
    if (zoom(p, local, part.box)) {
      open.push_back(std::move(part));
      continue;
    }
    const Box<Int> left = part_of(box, 1, 0, 1), right = part_of(box, 1, 1, 2);
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
  const Chain<Int> chain = signed_remainders(p, derivative(p));
  if (chain.back().degree > 0) {
    multiple_roots(p, chain.back(), roots);
    return;
  }
  if (sign_changes_at(chain, Int(), 0) == sign_changes_at(chain, Int(1), 0)) return;
  bisect_box(p, Box<Int>(), roots);
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

template <class Int>
int sign_at(const Polynomial<Int>& p, const Int& k, int m) {
  if (k.is_zero()) return p.c[0].sign();
  const Int rest = power_of_two<Int>(m) - k;
  if (rest.is_zero()) return p.c[p.degree].sign();
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
void Root<Int>::bisect() {
  Box<Int> right = part_of(box_, 1, 1, 2);
  const int s = sign_at(p_, right.k, right.m);
  if (s == 0) {
    Int rest = power_of_two<Int>(right.m) - right.k;
    const int kept = multiplicity;
    *this = rational(std::move(right.k), std::move(rest));
    multiplicity = kept;
  } else {
    box_ = s == sign_lo_ ? std::move(right) : part_of(box_, 1, 0, 1);
  }
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
  const auto step = static_cast<std::int64_t>(std::ldexp(guess(), kGuessedBits));
  constexpr std::int64_t kCells = std::int64_t{1} << kGuessedBits;
  if (step >= 0 && step < kCells) {
    Box<Int> cell = part_of(box_, kGuessedBits, step, step + 1);
    // At the ends of the box the sides are known.
    if ((step == 0 || sign_at(p_, cell.k, cell.m) == sign_lo_) &&
        (step + 1 == kCells || sign_at(p_, cell.end(), cell.m) == -sign_lo_)) {
      box_ = std::move(cell);
      return;
    }
  }
  bisect();
}

template <class Int>
int Root<Int>::sign_if_clear(const Polynomial<Int>& q) const {
  if (rational_) {
    if (num_.is_zero()) return q.c[0].sign();
    if (den_.is_zero()) return q.c[q.degree].sign();
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

/// Whether q is zero at the root a of p, the only one in the box. Let r = p mod q, which is at most
/// linear. If r is zero, all roots of q are roots of p, and q(a) = 0 iff q has a root in the box.
/// Otherwise a common root is a root of r and hence rational: the root then becomes a rational one.
template <class Int>
bool Root<Int>::vanishes(Polynomial<Int> q) {
  const Polynomial<Int> whole = q;
  drop_leading_zeros(q);
  if (q.degree == 0) return false;
  const Polynomial<Int> r = remainder(p_, q);
  if (r.is_zero()) {
    const Polynomial<Int> local = restrict_to(whole, box_);
    return sign_changes(local) % 2 == 1;
  }
  if (r.degree == 0 || sign_at(r, box_.k, box_.m) * sign_at(r, box_.end(), box_.m) >= 0)
    return false;
  Root<Int> common = rational(magnitude(r.c[0]), magnitude(r.c[1]));
  if (common.sign_if_clear(q) != 0) return false;
  common.multiplicity = multiplicity;
  *this = std::move(common);
  return true;
}

/// Terminates: if q does not vanish, its sign becomes clear on a small enough box.
template <class Int>
int Root<Int>::sign(const Polynomial<Int>& q) {
  if (q.is_zero()) return 0;
  bool known_nonzero = false;
  while (!rational_) {
    if (const int s = sign_if_clear(q); s != 0) return s;
    if (known_nonzero) {
      if (const int s = strict_sign(restrict_to(q, box_)); s != 0) return s;
    } else if (box_.m >= kGuessedBits) {
      if (vanishes(q)) return 0;
      known_nonzero = true;
      continue;
    }
    narrow();
  }
  return sign_if_clear(q);
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
