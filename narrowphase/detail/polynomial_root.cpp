// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/detail/polynomial_box.h>
#include <selvedge/narrowphase/detail/polynomial_division.h>
#include <selvedge/narrowphase/detail/polynomial_sign.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace selvedge::detail {
namespace {

double ordered_double(std::int64_t bits) { return Eigen::numext::bit_cast<double>(bits); }
std::int64_t ordered_bits(double x) { return Eigen::numext::bit_cast<std::int64_t>(x); }

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
double Root<Int>::lower_bound() const {
  bool exact = false;
  if (!rational_) return floor_of_dyadic(box_.k, box_.m, exact);
  // Both mantissas are truncated and the quotient is rounded: together less than 4 * 2^-53 of it,
  // and half a step where it is subnormal.
  constexpr double kRounding = 0x1p-50;
  const double t = quotient();
  return std::max(t - kRounding * t - std::numeric_limits<double>::denorm_min(), 0.0);
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

template class Root<BigInt>;
template class Root<SmallInt>;

}  // namespace selvedge::detail
