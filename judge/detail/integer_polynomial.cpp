// SPDX-License-Identifier: MIT
#include <selvedge/judge/detail/integer_polynomial.h>

#include <algorithm>
#include <cmath>

namespace selvedge::judging {
namespace {

// Number of narrowing steps before Root::sign_of tests whether the sign is 0. It affects only the
// speed: a gcd costs more than a step, and the first step decides most signs.
constexpr int steps_before_gcd = 2;
// A step narrows the interval by 2^-40 at most. With so few bits, the cell that the approximate
// root in doubles selects nearly always contains the root.
constexpr unsigned most_step_bits = 40;

void trim(Polynomial& p) {
  while (!p.empty() && p.back() == 0) p.pop_back();
}

void make_primitive(Polynomial& p) {
  mpz_class content = 0;
  for (const mpz_class& c : p) content = gcd(content, c);
  if (content > 1)
    for (mpz_class& c : p) mpz_divexact(c.get_mpz_t(), c.get_mpz_t(), content.get_mpz_t());
}

Polynomial derivative(const Polynomial& p) {
  Polynomial d;
  for (std::size_t i = 1; i < p.size(); ++i) d.emplace_back(p[i] * static_cast<unsigned long>(i));
  return d;
}

// Primitive part of the remainder of a multiple of a divided by b.
Polynomial pseudo_remainder(Polynomial a, const Polynomial& b) {
  while (a.size() >= b.size()) {
    const mpz_class lead = a.back();
    const std::size_t shift = a.size() - b.size();
    for (mpz_class& c : a) c *= b.back();
    for (std::size_t i = 0; i < b.size(); ++i) a[shift + i] -= lead * b[i];
    trim(a);
  }
  make_primitive(a);
  return a;
}

// Greatest common divisor up to a constant factor.
Polynomial greatest_common_divisor(Polynomial a, Polynomial b) {
  while (!b.empty()) {
    Polynomial rest = pseudo_remainder(std::move(a), b);
    a = std::move(b);
    b = std::move(rest);
  }
  make_primitive(a);
  return a;
}

// a / b up to a constant factor, for primitive b that divides a. By Gauss's lemma, the quotient of
// primitive polynomials has integer coefficients.
Polynomial quotient(Polynomial a, const Polynomial& b) {
  make_primitive(a);
  Polynomial q(a.size() - b.size() + 1);
  for (std::size_t k = q.size(); k-- > 0;) {
    mpz_divexact(q[k].get_mpz_t(), a[k + b.size() - 1].get_mpz_t(), b.back().get_mpz_t());
    for (std::size_t i = 0; i < b.size(); ++i) a[k + i] -= q[k] * b[i];
  }
  return q;
}

Polynomial square_free_part(const Polynomial& p) {
  const Polynomial common = greatest_common_divisor(p, derivative(p));
  return common.size() > 1 ? quotient(p, common) : p;
}

unsigned long binomial(unsigned long n, unsigned long k) {
  unsigned long value = 1;
  for (unsigned long i = 0; i < k; ++i) value = value * (n - i) / (i + 1);
  return value;
}

int variations(const std::vector<int>& signs) {
  int count = 0, last = 0;
  for (const int s : signs) {
    if (s == 0) continue;
    if (last != 0 && s != last) ++count;
    last = s;
  }
  return count;
}

int first_sign(const std::vector<int>& signs) {
  const auto s = std::find_if(signs.begin(), signs.end(), [](int v) { return v != 0; });
  return s == signs.end() ? 0 : *s;
}

// +1 or -1 if all coefficients have that strict sign, 0 otherwise. The polynomial then has the same
// sign on the whole closed interval.
int common_sign(const std::vector<int>& signs) {
  return std::all_of(signs.begin(), signs.end(), [&](int s) { return s == signs[0]; }) ? signs[0]
                                                                                       : 0;
}

// Descartes' rule in the Bernstein basis: the number of roots in the open interval is the number of
// sign variations or smaller by an even number, so the counts 0 and 1 are exact. For a square-free
// polynomial, bisection terminates [CollinsAkritas1976].
void isolate(const Polynomial& square_free, const mpz_class& k, unsigned m,
             std::vector<Root>& roots) {
  const int count = variations(bernstein_signs(square_free, k, m));
  if (count == 0) return;
  if (count == 1) {
    roots.emplace_back(square_free, k, m);
    return;
  }
  const mpz_class left = 2 * k, middle = left + 1;
  isolate(square_free, left, m + 1, roots);
  if (sign_at(square_free, {middle, m + 1}) == 0) roots.emplace_back(DyadicTime{middle, m + 1});
  isolate(square_free, middle, m + 1, roots);
}

// 2^(bits n) p((shift + s)/2^bits) as a polynomial in s, where n is the degree of p.
Polynomial restricted(Polynomial p, const mpz_class& shift, unsigned bits) {
  if (p.empty()) return p;
  const std::size_t n = p.size() - 1;
  for (std::size_t i = 0; i < n; ++i) p[i] <<= bits * static_cast<unsigned>(n - i);
  if (shift != 0)
    for (std::size_t pass = 0; pass < n; ++pass)
      for (std::size_t i = n; i-- > pass;)
        mpz_addmul(p[i].get_mpz_t(), shift.get_mpz_t(), p[i + 1].get_mpz_t());
  return p;
}

// The coefficients, scaled by a common power of two so that the largest is about 1.
std::vector<double> to_doubles(const Polynomial& p) {
  std::vector<double> fraction(p.size());
  std::vector<long> exponent(p.size());
  long top = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    fraction[i] = mpz_get_d_2exp(&exponent[i], p[i].get_mpz_t());
    top = std::max(top, exponent[i]);
  }
  constexpr long lowest = -1100;
  for (std::size_t i = 0; i < p.size(); ++i)
    fraction[i] = std::ldexp(fraction[i], static_cast<int>(std::max(exponent[i] - top, lowest)));
  return fraction;
}

// Approximate root of p in (0,1), computed in doubles. Just right of 0, p has the sign `left_sign`.
double guess_root(const Polynomial& p, int left_sign) {
  const std::vector<double> c = to_doubles(p);
  const auto value = [&c](double s) {
    double v = 0.0;
    for (std::size_t i = c.size(); i-- > 0;) v = v * s + c[i];
    return v;
  };
  const auto slope = [&c](double s) {
    double v = 0.0;
    for (std::size_t i = c.size(); i-- > 1;) v = v * s + static_cast<double>(i) * c[i];
    return v;
  };
  // Newton's method, safeguarded by a bracket.
  double lo = 0.0, hi = 1.0, s = 0.5;
  constexpr int steps = 60;
  for (int step = 0; step < steps; ++step) {
    const double v = value(s);
    if (v == 0.0) break;
    ((v > 0.0) == (left_sign > 0) ? lo : hi) = s;
    double next = s - v / slope(s);
    if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
    if (next == s || next == hi) break;  // the midpoint of neighbouring doubles rounds to one
    s = next;
  }
  return s;
}

// Largest double not above t >= 0. `exact` becomes true if it equals t.
double floor_of(const DyadicTime& t, bool& exact) {
  exact = true;
  if (t.numerator == 0) return 0.0;
  // The value is below 2^(bits - exponent). A double keeps 53 bits, fewer below 2^-1022.
  const long bits = static_cast<long>(mpz_sizeinbase(t.numerator.get_mpz_t(), 2));
  const long unit = std::max(bits - 53 - static_cast<long>(t.exponent), -1074L);
  const long dropped = unit + static_cast<long>(t.exponent);
  mpz_class kept;
  if (dropped > 0) {
    mpz_fdiv_q_2exp(kept.get_mpz_t(), t.numerator.get_mpz_t(), static_cast<unsigned long>(dropped));
    exact = mpz_scan1(t.numerator.get_mpz_t(), 0) >= static_cast<unsigned long>(dropped);
  } else {
    kept = t.numerator << static_cast<unsigned long>(-dropped);
  }
  return std::ldexp(kept.get_d(), static_cast<int>(unit));
}

DyadicTime to_dyadic(double x) {
  int exponent = 0;
  const double fraction = std::frexp(x, &exponent);
  constexpr int bits = 53;
  mpz_class numerator(std::ldexp(fraction, bits));
  return {std::move(numerator), static_cast<unsigned>(bits - exponent)};
}

}  // namespace

Polynomial operator+(const Polynomial& a, const Polynomial& b) {
  Polynomial sum = a.size() >= b.size() ? a : b;
  const Polynomial& shorter = a.size() >= b.size() ? b : a;
  for (std::size_t i = 0; i < shorter.size(); ++i) sum[i] += shorter[i];
  trim(sum);
  return sum;
}

Polynomial operator-(const Polynomial& a, const Polynomial& b) {
  Polynomial difference = a;
  if (difference.size() < b.size()) difference.resize(b.size());
  for (std::size_t i = 0; i < b.size(); ++i) difference[i] -= b[i];
  trim(difference);
  return difference;
}

Polynomial operator*(const Polynomial& a, const Polynomial& b) {
  if (a.empty() || b.empty()) return {};
  Polynomial product(a.size() + b.size() - 1);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j)
      mpz_addmul(product[i + j].get_mpz_t(), a[i].get_mpz_t(), b[j].get_mpz_t());
  return product;
}

int sign_at(const Polynomial& p, const DyadicTime& t) {
  // Horner's scheme on 2^(m n) p(x / 2^m).
  mpz_class value = 0, scaled;
  unsigned shift = 0;
  for (std::size_t i = p.size(); i-- > 0; shift += t.exponent) {
    scaled = p[i] << shift;
    value = value * t.numerator + scaled;
  }
  return sgn(value);
}

std::vector<int> bernstein_signs(const Polynomial& p, const mpz_class& k, unsigned m) {
  if (p.empty()) return {0};
  const std::size_t n = p.size() - 1;
  const Polynomial c = restricted(p, k, m);
  // b_j = sum over i <= j of C(j,i)/C(n,i) c_i, and C(j,i)/C(n,i) = C(n-i,n-j)/C(n,j).
  std::vector<int> signs(n + 1);
  mpz_class b;
  for (std::size_t j = 0; j <= n; ++j) {
    b = 0;
    for (std::size_t i = 0; i <= j; ++i)
      mpz_addmul_ui(b.get_mpz_t(), c[i].get_mpz_t(), binomial(n - i, n - j));
    signs[j] = sgn(b);
  }
  return signs;
}

bool has_evidently_no_root(const Polynomial& p) {
  return common_sign(bernstein_signs(p, 0, 0)) != 0;
}

Root::Root(Polynomial p, mpz_class k, unsigned m)
    : p_(std::move(p)), k_(std::move(k)), m_(m), step_bits_(most_step_bits) {
  left_sign_ = first_sign(bernstein_signs(p_, k_, m_));
  local_ = restricted(p_, k_, m_);
}

// Narrows the interval to its part from cell/2^bits to (cell+1)/2^bits if the signs at the ends of
// the part show that it contains the root. At the ends of the interval itself, p may have other
// roots; the signs just inside them are known.
bool Root::narrow_to(const mpz_class& cell, unsigned bits) {
  const mpz_class last_cell = (mpz_class(1) << bits) - 1;
  if (cell > last_cell) return false;
  Polynomial part = restricted(local_, cell, bits);
  mpz_class at_end = 0;
  for (const mpz_class& c : part) at_end += c;
  const bool last = cell == last_cell;
  const int low = cell == 0 ? left_sign_ : sgn(part[0]);
  const int high = last ? -left_sign_ : sgn(at_end);
  if (low == -left_sign_ || high == left_sign_) return false;
  exact_ = low == 0 || high == 0;
  k_ = (k_ << bits) + cell;
  if (high == 0) ++k_;
  local_ = std::move(part);
  m_ += bits;
  return true;
}

// Quadratic refinement [Abbott2012]: if a step selects the cell that contains the root, the next
// step uses twice as many bits, otherwise half as many, down to bisection.
void Root::narrow() {
  const double guess = guess_root(local_, left_sign_);
  for (; step_bits_ > 1; step_bits_ /= 2)
    if (narrow_to(mpz_class(std::ldexp(guess, static_cast<int>(step_bits_))), step_bits_)) {
      step_bits_ = std::min(2 * step_bits_, most_step_bits);
      return;
    }
  if (!narrow_to(0, 1)) narrow_to(1, 1);
  step_bits_ = 2;
}

// In the interval, the common divisor has no other root than this one, which is simple. The number
// of its roots there is therefore 0 or 1 and has the parity of the sign variations.
bool Root::is_root_of(const Polynomial& q) const {
  const Polynomial common = greatest_common_divisor(p_, q);
  return common.size() > 1 && variations(bernstein_signs(common, k_, m_)) % 2 == 1;
}

int Root::sign_of(const Polynomial& q) {
  if (q.empty()) return 0;
  for (int step = 0; !exact_; ++step) {
    if (const int sign = common_sign(bernstein_signs(q, k_, m_)); sign != 0) return sign;
    if (step == steps_before_gcd && is_root_of(q)) return 0;
    narrow();
  }
  return sign_at(q, {k_, m_});
}

TimeEnclosure Root::enclosure_of_exact() const {
  bool is_double = false;
  const double lo = floor_of({k_, m_}, is_double);
  return {lo, is_double ? lo : std::nextafter(lo, 2.0)};
}

// Narrows until at most one double lies strictly inside the interval. The sign of p at this double
// shows on which side the root lies.
TimeEnclosure Root::enclosure() {
  while (!exact_) {
    bool low_is_double = false, high_is_double = false;
    const double low = floor_of({k_, m_}, low_is_double);
    double high = floor_of({k_ + 1, m_}, high_is_double);
    if (!high_is_double) high = std::nextafter(high, 2.0);
    const double inner = std::nextafter(low, 2.0);
    if (inner == high) return {low, high};
    if (std::nextafter(inner, 2.0) == high) {
      const int sign = sign_at(p_, to_dyadic(inner));
      if (sign == 0) return {inner, inner};
      return sign == left_sign_ ? TimeEnclosure{inner, high} : TimeEnclosure{low, inner};
    }
    narrow();
  }
  return enclosure_of_exact();
}

std::vector<Root> roots_in_unit_interval(const Polynomial& p) {
  std::vector<Root> roots;
  if (p.size() <= 1) return roots;
  const std::vector<int> signs = bernstein_signs(p, 0, 0);
  if (common_sign(signs) != 0) return roots;
  // One sign variation means exactly one root between the ends. It is simple, even if p has
  // multiple roots elsewhere.
  const int count = variations(signs);
  if (sign_at(p, {0, 0}) == 0) roots.emplace_back(DyadicTime{0, 0});
  if (count == 1) roots.emplace_back(p, 0, 0);
  if (count > 1) isolate(square_free_part(p), 0, 0, roots);
  if (sign_at(p, {1, 0}) == 0) roots.emplace_back(DyadicTime{1, 0});
  return roots;
}

}  // namespace selvedge::judging
