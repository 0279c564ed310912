// SPDX-License-Identifier: MIT
#include <selvedge/apps/detail/integer_polynomial.h>

#include <algorithm>

namespace selvedge::judging {
namespace {

// Narrowing steps before Root::sign_of asks whether the sign is 0. Any number is correct: a gcd
// costs about as much as a few steps, and most signs are decided by the first.
constexpr int steps_before_gcd = 3;

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

// Remainder of a multiple of a by b, primitive.
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

// Up to a constant.
Polynomial greatest_common_divisor(Polynomial a, Polynomial b) {
  while (!b.empty()) {
    Polynomial rest = pseudo_remainder(std::move(a), b);
    a = std::move(b);
    b = std::move(rest);
  }
  make_primitive(a);
  return a;
}

// a / b for primitive b that divides a, up to a constant. By Gauss's lemma the quotient of
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

// +1 or -1 if all coefficients have that strict sign: so has the polynomial on the closed interval.
int common_sign(const std::vector<int>& signs) {
  return std::all_of(signs.begin(), signs.end(), [&](int s) { return s == signs[0]; }) ? signs[0]
                                                                                       : 0;
}

// Descartes' rule in the Bernstein basis: the number of roots in the open interval is the number of
// sign variations or less by an even number, so 0 and 1 are certain; for a square-free polynomial
// halving ends [CollinsAkritas1976].
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
  // 2^(m n) p((k + s) / 2^m) as a polynomial in s: scaled, then shifted by k.
  Polynomial c = p;
  for (std::size_t i = 0; i < n; ++i) c[i] <<= m * static_cast<unsigned>(n - i);
  if (k != 0)
    for (std::size_t pass = 0; pass < n; ++pass)
      for (std::size_t i = n; i-- > pass;) c[i] += k * c[i + 1];
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

Root::Root(Polynomial square_free, mpz_class k, unsigned m)
    : square_free_(std::move(square_free)), k_(std::move(k)), m_(m) {
  left_sign_ = first_sign(bernstein_signs(square_free_, k_, m_));
}

void Root::narrow() {
  const DyadicTime middle{2 * k_ + 1, m_ + 1};
  const int sign = selvedge::judging::sign_at(square_free_, middle);
  exact_ = sign == 0;
  k_ = sign == 0 || sign == left_sign_ ? middle.numerator : mpz_class(middle.numerator - 1);
  ++m_;
}

// The common divisor's roots in the interval are at most this one and simple, so their number is 0
// or 1 and has the parity of the sign variations.
bool Root::is_root_of(const Polynomial& q) const {
  const Polynomial common = greatest_common_divisor(square_free_, q);
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

std::vector<Root> roots_in_unit_interval(const Polynomial& p) {
  std::vector<Root> roots;
  if (p.size() <= 1 || has_evidently_no_root(p)) return roots;
  const Polynomial square_free = square_free_part(p);
  for (const int end : {0, 1})
    if (sign_at(square_free, {end, 0}) == 0) roots.emplace_back(DyadicTime{end, 0});
  isolate(square_free, 0, 0, roots);
  return roots;
}

}  // namespace selvedge::judging
