// SPDX-License-Identifier: MIT
#include <selvedge/core/check.h>
#include <selvedge/narrowphase/detail/polynomial.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace selvedge::narrowphase_detail {
namespace {

/// Bits that one look at the root in doubles adds to a box: few enough against the rounding of
/// doubles that the guess is nearly always confirmed.
constexpr int kGuessedBits = 40;

/// Polynomials in u = t / (1 - t) with a nonzero leading coefficient, for division.
using Chain = std::vector<Polynomial>;

void drop_leading_zeros(Polynomial& p) {
  while (p.degree > 0 && p.c[p.degree].is_zero()) --p.degree;
}

/// Divides by the power of two that all coefficients share.
void drop_content(Polynomial& p) {
  int shift = std::numeric_limits<int>::max();
  for (int i = 0; i <= p.degree; ++i)
    if (!p.c[i].is_zero()) shift = std::min(shift, p.c[i].trailing_zeros());
  if (shift == 0 || shift == std::numeric_limits<int>::max()) return;
  for (int i = 0; i <= p.degree; ++i) p.c[i] = p.c[i] >> shift;
}

/// A positive multiple of a mod b in Q[u].
Polynomial remainder(Polynomial a, const Polynomial& b) {
  drop_leading_zeros(a);
  const BigInt& lead = b.c[b.degree];
  const BigInt factor = lead.sign() < 0 ? -lead : lead;
  while (a.degree >= b.degree && !a.is_zero()) {
    const BigInt top = lead.sign() < 0 ? -a.c[a.degree] : a.c[a.degree];
    const int shift = a.degree - b.degree;
    for (int i = 0; i < a.degree; ++i) {
      a.c[i] = a.c[i] * factor;
      if (i >= shift) a.c[i] = a.c[i] - top * b.c[i - shift];
    }
    a.c[a.degree] = BigInt();
    if (a.degree == 0) break;
    drop_leading_zeros(a);
  }
  drop_content(a);
  return a;
}

/// Signed remainder sequence of p and q: a, b, -(a mod b), ... up to the greatest common divisor,
/// each up to a positive factor.
Chain signed_remainders(const Polynomial& p, Polynomial q) {
  Chain chain{p};
  q = remainder(std::move(q), p);
  while (!q.is_zero()) {
    chain.push_back(q);
    if (q.degree == 0) break;
    Polynomial r = remainder(chain[chain.size() - 2], q);
    for (BigInt& c : r.c) c = -c;
    q = std::move(r);
  }
  return chain;
}

Polynomial derivative(const Polynomial& p) {
  Polynomial d;
  d.degree = std::max(p.degree - 1, 0);
  for (int i = 1; i <= p.degree; ++i) d.c[i - 1] = p.c[i] * BigInt(i);
  return d;
}

/// Sign changes in a sequence, zeros left out.
class SignChanges {
 public:
  void add(int sign) {
    if (sign == 0) return;
    if (last_ != 0 && sign != last_) ++count_;
    last_ = sign;
  }
  int count() const { return count_; }

 private:
  int last_ = 0, count_ = 0;
};

int sign_changes(const Polynomial& p) {
  SignChanges changes;
  for (int i = 0; i <= p.degree; ++i) changes.add(p.c[i].sign());
  return changes.count();
}

int sign_changes_at(const Chain& chain, const BigInt& k, int m) {
  SignChanges changes;
  for (const Polynomial& p : chain) changes.add(sign_at(p, k, m));
  return changes.count();
}

BigInt power_of_two(int m) { return BigInt(1) << m; }

BigInt magnitude(const BigInt& a) { return a.sign() < 0 ? -a : a; }

/// p on the box [k, k + 1] / 2^m, in the same form, times a power of two.
Polynomial restrict_to(const Polynomial& p, const BigInt& k, int m) {
  if (m == 0) return p;
  // With s the place in the box: 1 - t ~ a (1-s) + b s, t ~ c (1-s) + d s.
  Polynomial one_minus_t, t;
  one_minus_t.degree = t.degree = 1;
  t.c = {k, k + BigInt(1)};
  one_minus_t.c = {power_of_two(m) - t.c[0], power_of_two(m) - t.c[1]};
  Polynomial result, power;
  result.c[0] = p.c[p.degree];
  power.c[0] = BigInt(1);
  for (int i = p.degree; i-- > 0;) {
    result = result * t;
    power = power * one_minus_t;
    for (int j = 0; j <= result.degree; ++j) result.c[j] = result.c[j] + power.c[j] * p.c[i];
  }
  return result;
}

/// +1 or -1 if all coefficients have that strict sign, so that the sign holds on the closed box.
int strict_sign(const Polynomial& p) {
  const int s = p.c[0].sign();
  for (int i = 1; i <= p.degree; ++i)
    if (p.c[i].sign() != s) return 0;
  return s;
}

int first_sign(const Polynomial& p) {
  for (int i = 0; i <= p.degree; ++i)
    if (!p.c[i].is_zero()) return p.c[i].sign();
  return 0;
}

/// Roots of a square-free p strictly inside a box. Ends by the two-circle theorem of Obreshkoff:
/// small boxes have at most one sign change.
void bisect_box(const Polynomial& p, const BigInt& k, int m, std::vector<Root>& roots) {
  const Polynomial local = restrict_to(p, k, m);
  const int changes = sign_changes(local);
  if (changes == 0) return;
  if (changes == 1) {
    roots.push_back(Root::isolated(p, k, m, first_sign(local)));
    return;
  }
  const BigInt left = k << 1;
  const BigInt middle = left + BigInt(1);
  bisect_box(p, left, m + 1, roots);
  if (sign_at(p, middle, m + 1) == 0)
    roots.push_back(Root::rational(middle, power_of_two(m + 1) - middle));
  bisect_box(p, middle, m + 1, roots);
}

void push_if_positive(const BigInt& num, const BigInt& den, int multiplicity,
                      std::vector<Root>& roots) {
  if (num.sign() * den.sign() <= 0) return;
  roots.push_back(Root::rational(magnitude(num), magnitude(den)));
  roots.back().multiplicity = multiplicity;
}

/// Roots u > 0 of a quadratic or cubic p that has a multiple root: all of them are rational.
/// `common` is gcd(p, p').
void multiple_roots(const Polynomial& p, const Polynomial& common, std::vector<Root>& roots) {
  if (common.degree == 2) {  // (u - r)^3
    push_if_positive(-common.c[1], common.c[2] << 1, 3, roots);
    return;
  }
  // common = h1 u + h0 and p = (h1 u + h0)^2 (m1 u + m0) / w: the other root is -m0 / m1.
  const BigInt& h0 = common.c[0];
  const BigInt& h1 = common.c[1];
  push_if_positive(-h0, h1, 2, roots);
  if (p.degree < 3) return;
  const BigInt num = -(p.c[0] * h1 * h1);
  const BigInt den = p.c[3] * h0 * h0;
  const std::size_t n = roots.size();
  const bool had_double = h0.sign() * h1.sign() < 0;
  push_if_positive(num, den, 1, roots);
  if (!had_double || roots.size() == n) return;
  // Ascending: -h0 / h1 against num / den.
  if ((magnitude(num) * magnitude(h1) - magnitude(h0) * magnitude(den)).sign() < 0)
    std::swap(roots[n - 1], roots[n]);
}

/// Roots in the open interval (0, 1) of p with nonzero outer coefficients.
void interior_roots(const Polynomial& p, std::vector<Root>& roots) {
  const int changes = sign_changes(p);
  if (changes == 0) return;
  if (p.degree == 1) {
    push_if_positive(-p.c[0], p.c[1], 1, roots);
    return;
  }
  if (changes == 1) {
    roots.push_back(Root::isolated(p, BigInt(), 0, p.c[0].sign()));
    return;
  }
  const Chain chain = signed_remainders(p, derivative(p));
  if (chain.back().degree > 0) {
    multiple_roots(p, chain.back(), roots);
    return;
  }
  if (sign_changes_at(chain, BigInt(), 0) == sign_changes_at(chain, BigInt(1), 0)) return;
  bisect_box(p, BigInt(), 0, roots);
}

double ordered_double(std::int64_t bits) { return std::bit_cast<double>(bits); }
std::int64_t ordered_bits(double x) { return std::bit_cast<std::int64_t>(x); }

/// x >= 0 as k / 2^m.
void to_dyadic(double x, BigInt& k, int& m) {
  int e = 0;
  std::frexp(x, &e);
  constexpr int kMantissaBits = 53;
  m = std::max(kMantissaBits - e, 0);
  m = std::min(m, 1074);
  k = BigInt::from_double(x, -m);
}

int sign_at_double(const Polynomial& p, double t) {
  BigInt k;
  int m = 0;
  to_dyadic(t, k, m);
  return sign_at(p, k, m);
}

/// The largest double not above k / 2^m, and whether it is that number.
double floor_of_dyadic(const BigInt& k, int m, bool& exact) {
  exact = k.is_zero();
  if (exact) return 0.0;
  int e = 0;
  const double f = k.mantissa(e);
  const double x = std::ldexp(f, e - m);
  if (x == 0.0) return 0.0;
  BigInt kx;
  int mx = 0;
  to_dyadic(x, kx, mx);
  // ldexp rounds only where the result is subnormal.
  const BigInt excess = (kx << std::max(m - mx, 0)) - (k << std::max(mx - m, 0));
  exact = excess.is_zero();
  return excess.sign() > 0 ? std::nextafter(x, 0.0) : x;
}

}  // namespace

bool Polynomial::is_zero() const {
  for (int i = 0; i <= degree; ++i)
    if (!c[i].is_zero()) return false;
  return true;
}

Polynomial operator+(const Polynomial& a, const Polynomial& b) {
  Polynomial r;
  r.degree = a.degree;
  for (int i = 0; i <= a.degree; ++i) r.c[i] = a.c[i] + b.c[i];
  return r;
}

Polynomial operator-(const Polynomial& a, const Polynomial& b) {
  Polynomial r;
  r.degree = a.degree;
  for (int i = 0; i <= a.degree; ++i) r.c[i] = a.c[i] - b.c[i];
  return r;
}

Polynomial operator*(const Polynomial& a, const Polynomial& b) {
  Polynomial r;
  r.degree = a.degree + b.degree;
  SELVEDGE_ASSERT(r.degree <= Polynomial::kMaxDegree);
  for (int i = 0; i <= a.degree; ++i) {
    if (a.c[i].is_zero()) continue;
    for (int j = 0; j <= b.degree; ++j)
      if (!b.c[j].is_zero()) r.c[i + j] = r.c[i + j] + a.c[i] * b.c[j];
  }
  return r;
}

int sign_at(const Polynomial& p, const BigInt& k, int m) {
  if (k.is_zero()) return p.c[0].sign();
  const BigInt rest = power_of_two(m) - k;
  if (rest.is_zero()) return p.c[p.degree].sign();
  // Homogeneous Horner scheme: sum of c[i] k^i rest^(n-i).
  BigInt value = p.c[p.degree];
  BigInt power(1);
  for (int i = p.degree; i-- > 0;) {
    power = power * rest;
    value = value * k;
    if (!p.c[i].is_zero()) value = value + p.c[i] * power;
  }
  return value.sign();
}

Root Root::rational(BigInt num, BigInt den) {
  Root r;
  r.rational_ = true;
  r.num_ = std::move(num);
  r.den_ = std::move(den);
  return r;
}

Root Root::isolated(Polynomial p, BigInt k, int m, int sign_lo) {
  Root r;
  r.rational_ = false;
  r.p_ = std::move(p);
  r.k_ = std::move(k);
  r.m_ = m;
  r.sign_lo_ = sign_lo;
  return r;
}

void Root::bisect() {
  const BigInt left = k_ << 1;
  BigInt middle = left + BigInt(1);
  ++m_;
  const int s = sign_at(p_, middle, m_);
  if (s == 0) {
    BigInt rest = power_of_two(m_) - middle;
    const int kept = multiplicity;
    *this = rational(std::move(middle), std::move(rest));
    multiplicity = kept;
  } else {
    k_ = s == sign_lo_ ? std::move(middle) : left;
  }
}

/// The root in doubles, as a place in the box: no accuracy is promised and none is needed, because
/// every use checks exact signs around it.
double Root::guess() const {
  const Polynomial local = restrict_to(p_, k_, m_);
  std::array<double, Polynomial::kMaxDegree + 1> c{};
  int top = 0;
  for (int i = 0; i <= local.degree; ++i) top = std::max(top, local.c[i].bit_length());
  for (int i = 0; i <= local.degree; ++i) {
    int e = 0;
    const double f = local.c[i].mantissa(e);
    c[i] = std::ldexp(f, e - top);
  }
  const auto value = [&](double s) {
    double v = c[local.degree], power = 1.0;
    for (int i = local.degree; i-- > 0;) {
      power *= 1.0 - s;
      v = v * s + c[i] * power;
    }
    return v;
  };
  // Illinois variant of the false position [Dowell, Jarratt 1971]: bracketed and superlinear.
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
/// it, else halves it.
void Root::narrow() {
  const auto step = static_cast<std::int64_t>(std::ldexp(guess(), kGuessedBits));
  constexpr std::int64_t kCells = std::int64_t{1} << kGuessedBits;
  if (step > 0 && step + 1 < kCells) {
    BigInt k = (k_ << kGuessedBits) + BigInt(step);
    const int m = m_ + kGuessedBits;
    if (sign_at(p_, k, m) == sign_lo_ && sign_at(p_, k + BigInt(1), m) == -sign_lo_) {
      k_ = std::move(k);
      m_ = m;
      return;
    }
  }
  bisect();
}

int Root::sign_if_clear(const Polynomial& q) const {
  if (rational_) {
    if (num_.is_zero()) return q.c[0].sign();
    if (den_.is_zero()) return q.c[q.degree].sign();
    BigInt value = q.c[q.degree];
    BigInt power(1);
    for (int i = q.degree; i-- > 0;) {
      power = power * den_;
      value = value * num_ + q.c[i] * power;
    }
    return value.sign();
  }
  return strict_sign(restrict_to(q, k_, m_));
}

/// Whether q is zero at the root a of p, the only one in the box. With r = p mod q, at most linear:
/// if r is zero, all roots of q are roots of p, and q(a) = 0 iff q has a root in the box. Otherwise
/// a common root is one of r, so that it is rational: then the root becomes a rational one.
bool Root::vanishes(Polynomial q) {
  const Polynomial local = restrict_to(q, k_, m_);
  drop_leading_zeros(q);
  if (q.degree == 0) return false;
  const Polynomial r = remainder(p_, q);
  if (r.is_zero()) return sign_changes(local) % 2 == 1;
  if (r.degree == 0 || sign_at(r, k_, m_) * sign_at(r, k_ + BigInt(1), m_) >= 0) return false;
  Root common = rational(magnitude(r.c[0]), magnitude(r.c[1]));
  if (common.sign_if_clear(q) != 0) return false;
  common.multiplicity = multiplicity;
  *this = std::move(common);
  return true;
}

/// Ends: where q does not vanish its sign becomes clear on a box small enough.
int Root::sign(const Polynomial& q) {
  if (q.is_zero()) return 0;
  bool known_nonzero = false;
  while (!rational_) {
    if (const int s = sign_if_clear(q); s != 0) return s;
    if (m_ >= kGuessedBits && !known_nonzero) {
      if (vanishes(q)) return 0;
      known_nonzero = true;
    }
    narrow();
  }
  return sign_if_clear(q);
}

double Root::floor(bool& exact) const {
  if (rational_) {
    exact = true;
    if (num_.is_zero()) return 0.0;
    if (den_.is_zero()) return 1.0;
    Polynomial line;
    line.degree = 1;
    line.c = {-num_, den_};
    return isolated(line, BigInt(), 0, -1).floor(exact);
  }
  exact = false;
  bool end_is_double = false;
  double lo = floor_of_dyadic(k_, m_, end_is_double);
  const double start = lo;
  double hi = floor_of_dyadic(k_ + BigInt(1), m_, end_is_double);
  if (!end_is_double) hi = std::nextafter(hi, 2.0);
  // Invariant: lo < root < hi. Signs are taken strictly inside the box, where they tell the side.
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
  const double width = std::ldexp(1.0, -m_);
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

void isolate_roots(const Polynomial& p, std::vector<Root>& roots) {
  SELVEDGE_ASSERT(!p.is_zero());
  Polynomial inner = p;
  drop_content(inner);
  int zeros = 0;
  while (inner.c[zeros].is_zero()) ++zeros;
  for (int i = 0; i + zeros <= inner.degree; ++i) inner.c[i] = inner.c[i + zeros];
  inner.degree -= zeros;
  const int before = inner.degree;
  drop_leading_zeros(inner);
  for (int i = inner.degree + 1; i <= Polynomial::kMaxDegree; ++i) inner.c[i] = BigInt();
  if (zeros > 0) {
    roots.push_back(Root::rational(BigInt(), BigInt(1)));
    roots.back().multiplicity = zeros;
  }
  if (inner.degree > 0) interior_roots(inner, roots);
  if (before > inner.degree) {
    roots.push_back(Root::rational(BigInt(1), BigInt()));
    roots.back().multiplicity = before - inner.degree;
  }
}

bool isolate_in_box(const Polynomial& p, const BigInt& k, int m, Root& root) {
  const Polynomial local = restrict_to(p, k, m);
  if (local.c[0].is_zero() || local.c[local.degree].is_zero() || sign_changes(local) != 1)
    return false;
  root = Root::isolated(p, k, m, local.c[0].sign());
  return true;
}

}  // namespace selvedge::narrowphase_detail
