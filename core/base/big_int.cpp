// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/big_int.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace selvedge {
namespace {

using Limb = std::uint64_t;
__extension__ typedef unsigned __int128 DoubleLimb;

/// out = a + b for na >= nb; returns the number of limbs, at most na + 1.
std::uint32_t add_limbs(Limb* out, const Limb* a, std::uint32_t na, const Limb* b,
                        std::uint32_t nb) {
  Limb carry = 0;
  std::uint32_t i = 0;
  for (; i < nb; ++i) {
    const DoubleLimb s = DoubleLimb{a[i]} + b[i] + carry;
    out[i] = static_cast<Limb>(s);
    carry = static_cast<Limb>(s >> 64);
  }
  for (; carry != 0 && i < na; ++i) {
    out[i] = a[i] + 1;
    carry = out[i] == 0 ? 1 : 0;
  }
  if (out != a) std::copy(a + i, a + na, out + i);
  if (carry != 0) out[na++] = carry;
  return na;
}

/// out = a - b for a >= b.
void subtract_limbs(Limb* out, const Limb* a, std::uint32_t na, const Limb* b, std::uint32_t nb) {
  Limb borrow = 0;
  std::uint32_t i = 0;
  for (; i < nb; ++i) {
    const Limb d = a[i] - b[i];
    const Limb below = (a[i] < b[i] ? 1U : 0U) | (d < borrow ? 1U : 0U);
    out[i] = d - borrow;
    borrow = below;
  }
  for (; borrow != 0 && i < na; ++i) {
    borrow = a[i] == 0 ? 1 : 0;
    out[i] = a[i] - 1;
  }
  if (out != a) std::copy(a + i, a + na, out + i);
}

/// out = x * y, nx + ny limbs.
void multiply_limbs(Limb* out, const Limb* x, std::uint32_t nx, const Limb* y, std::uint32_t ny) {
  for (std::uint32_t j = 0; j < ny; ++j) out[j] = 0;
  for (std::uint32_t i = 0; i < nx; ++i) {
    Limb carry = 0;
    for (std::uint32_t j = 0; j < ny; ++j) {
      const DoubleLimb p = DoubleLimb{x[i]} * y[j] + out[i + j] + carry;
      out[i + j] = static_cast<Limb>(p);
      carry = static_cast<Limb>(p >> 64);
    }
    out[i + ny] = carry;
  }
}

/// Numbers with fewer limbs than kShort are multiplied limb by limb; so are those with more than
/// kLongest, which no query makes.
constexpr std::uint32_t kShort = 12, kLongest = 1024;
__extension__ typedef __int128 SignedDoubleLimb;

/// The digits other than 0 of a number in base 2^64, each at least -2^63 and below 2^63.
///
/// The long numbers of the exact stage are sums of a few short ones at very different places, so
/// nearly all of their limbs are 0 or, after a subtraction, all ones. As a signed digit, a limb of
/// ones with a carry is 0, too.
struct SparseNumber {
  std::uint32_t count = 0;
  std::uint32_t place[kLongest + 1];
  std::int64_t digit[kLongest + 1];

  SparseNumber(const Limb* limbs, std::uint32_t n) {
    Limb carry = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
      if (limbs[i] == 0 && carry == 0) continue;
      const Limb sum = limbs[i] + carry;
      const bool wraps = carry != 0 && sum == 0;
      if (sum != 0) append(i, sum);
      carry = wraps || static_cast<std::int64_t>(sum) < 0 ? 1 : 0;
    }
    if (carry != 0) append(n, 1);
  }
  void append(std::uint32_t i, Limb value) {
    place[count] = i;
    digit[count++] = static_cast<std::int64_t>(value);
  }
};

/// out = x * y, n limbs: those of both factors.
void multiply_sparse(Limb* out, std::uint32_t n, const SparseNumber& x, const SparseNumber& y) {
  SignedDoubleLimb sum[2 * kLongest + 2];
  std::fill_n(sum, n + 2, SignedDoubleLimb{0});
  for (std::uint32_t i = 0; i < x.count; ++i)
    for (std::uint32_t j = 0; j < y.count; ++j) {
      const SignedDoubleLimb p = SignedDoubleLimb{x.digit[i]} * y.digit[j];
      SignedDoubleLimb* at = sum + x.place[i] + y.place[j];
      at[0] += static_cast<Limb>(p);
      at[1] += static_cast<std::int64_t>(p >> 64);
    }
  SignedDoubleLimb carry = 0;
  for (std::uint32_t k = 0; k < n; ++k) {
    if (sum[k] == 0 && carry == 0) {
      out[k] = 0;
      continue;
    }
    carry += sum[k];
    out[k] = static_cast<Limb>(carry);
    carry >>= 64;
  }
}

/// out = x * y, nx + ny limbs, for long numbers.
void multiply_long(Limb* out, const Limb* x, std::uint32_t nx, const Limb* y, std::uint32_t ny) {
  // A product of two digits takes about as long as this many of the limb-by-limb product.
  constexpr std::uint64_t kDigitCost = 3;
  const SparseNumber a(x, nx), b(y, ny);
  if (kDigitCost * a.count * b.count < std::uint64_t{nx} * ny)
    multiply_sparse(out, nx + ny, a, b);
  else
    multiply_limbs(out, x, nx, y, ny);
}

/// Buffers of long numbers that wait for the next ones of their thread: a query of such numbers
/// makes thousands of them. A buffer holds 2^kind limbs.
class SpareBuffers {
 public:
  static constexpr int kKinds = 12;

  SpareBuffers() = default;
  SpareBuffers(const SpareBuffers&) = delete;
  SpareBuffers& operator=(const SpareBuffers&) = delete;
  ~SpareBuffers() {
    for (int kind = 0; kind < kKinds; ++kind)
      for (int i = 0; i < count_[kind]; ++i) delete[] spare_[kind][i];
  }

  Limb* take(int kind) {
    if (kind < kKinds && count_[kind] > 0) return spare_[kind][--count_[kind]];
    return new Limb[std::size_t{1} << kind];
  }
  void give(Limb* buffer, int kind) {
    if (kind < kKinds && count_[kind] < kMost)
      spare_[kind][count_[kind]++] = buffer;
    else
      delete[] buffer;
  }

 private:
  static constexpr int kMost = 32;
  Limb* spare_[kKinds][kMost];
  int count_[kKinds] = {};
};

thread_local SpareBuffers spare_buffers;

int compare_limbs(const Limb* a, const Limb* b, std::uint32_t n) {
  while (n-- > 0)
    if (a[n] != b[n]) return a[n] < b[n] ? -1 : 1;
  return 0;
}

}  // namespace

BigInt::BigInt(std::int64_t value) {
  if (value == 0) return;
  negative_ = value < 0;
  inline_[0] = negative_ ? Limb{0} - static_cast<Limb>(value) : static_cast<Limb>(value);
  size_ = 1;
}

BigInt::BigInt(const BigInt& other) { *this = other; }

BigInt::BigInt(BigInt&& other) noexcept { *this = std::move(other); }

BigInt& BigInt::operator=(const BigInt& other) {
  if (this == &other) return *this;
  reserve(other.size_);
  const Limb* from = other.limbs();
  Limb* to = limbs();
  for (std::uint32_t i = 0; i < other.size_; ++i) to[i] = from[i];
  size_ = other.size_;
  negative_ = other.negative_;
  return *this;
}

BigInt& BigInt::operator=(BigInt&& other) noexcept {
  if (this == &other) return *this;
  release();
  size_ = other.size_;
  negative_ = other.negative_;
  if (other.capacity_ > kInline) {
    capacity_ = other.capacity_;
    heap_ = other.heap_;
    other.capacity_ = kInline;
  } else {
    for (std::uint32_t i = 0; i < size_; ++i) inline_[i] = other.inline_[i];
  }
  other.size_ = 0;
  return *this;
}

void BigInt::reserve(std::uint32_t n) {
  if (n <= capacity_) return;
  release();
  const int kind = std::bit_width(n - 1);
  heap_ = spare_buffers.take(kind);
  capacity_ = std::uint32_t{1} << kind;
}

void BigInt::give_back() { spare_buffers.give(heap_, std::countr_zero(capacity_)); }

void BigInt::trim(std::uint32_t n) {
  const Limb* l = limbs();
  while (n > 0 && l[n - 1] == 0) --n;
  size_ = n;
}

BigInt BigInt::from_double(double value, int exponent) {
  if (value == 0.0) return {};
  int e = 0;
  const double m = std::frexp(value, &e);
  constexpr int kMantissaBits = 53;
  BigInt r(static_cast<std::int64_t>(std::ldexp(m, kMantissaBits)));
  const int shift = e - kMantissaBits - exponent;
  return shift >= 0 ? r << shift : r >> -shift;
}

int BigInt::bit_length() const {
  if (size_ == 0) return 0;
  return static_cast<int>(64 * size_) - std::countl_zero(limbs()[size_ - 1]);
}

int BigInt::trailing_zeros() const {
  const Limb* l = limbs();
  for (std::uint32_t i = 0; i < size_; ++i)
    if (l[i] != 0) return static_cast<int>(64 * i) + std::countr_zero(l[i]);
  return 0;
}

double BigInt::mantissa(int& exponent) const {
  double rest = 0.0;
  return mantissa(exponent, rest);
}

double BigInt::mantissa(int& exponent, double& rest) const {
  exponent = bit_length();
  rest = 0.0;
  if (size_ == 0) return 0.0;
  // The leading 128 bits, in `high` and `low`.
  const Limb* l = limbs() + size_;
  const Limb top = l[-1], second = size_ > 1 ? l[-2] : 0, third = size_ > 2 ? l[-3] : 0;
  const int shift = std::countl_zero(top);
  const Limb high = shift == 0 ? top : top << shift | second >> (64 - shift);
  const Limb low = shift == 0 ? second : second << shift | third >> (64 - shift);
  // 53 of them, and the next 53: 11 of `high` and 42 of `low`.
  constexpr int kBeyond = 11, kMore = 42;
  const Limb next = (high & ((Limb{1} << kBeyond) - 1)) << kMore | low >> (64 - kMore);
  const double sign = negative_ ? -1.0 : 1.0;
  rest = sign * 0x1p-106 * static_cast<double>(next);
  return sign * 0x1p-53 * static_cast<double>(high >> kBeyond);
}

BigInt BigInt::operator-() const {
  BigInt r(*this);
  r.negative_ = !r.negative_;
  return r;
}

int BigInt::compare_magnitude(const BigInt& a, const BigInt& b) {
  if (a.size_ != b.size_) return a.size_ < b.size_ ? -1 : 1;
  const Limb* la = a.limbs();
  const Limb* lb = b.limbs();
  for (std::uint32_t i = a.size_; i-- > 0;)
    if (la[i] != lb[i]) return la[i] < lb[i] ? -1 : 1;
  return 0;
}

BigInt BigInt::add(const BigInt& a, const BigInt& b, bool b_negative) {
  BigInt r;
  if (b.size_ == 0) return a;
  if (a.size_ == 0) {
    r = b;
    r.negative_ = b_negative;
    return r;
  }
  const bool a_first = compare_magnitude(a, b) >= 0;
  const BigInt& big = a_first ? a : b;
  const BigInt& small = a_first ? b : a;
  r.negative_ = a_first ? a.negative_ : b_negative;
  if (a.negative_ == b_negative) {
    r.reserve(big.size_ + 1);
    r.size_ = add_limbs(r.limbs(), big.limbs(), big.size_, small.limbs(), small.size_);
  } else {
    r.reserve(big.size_);
    subtract_limbs(r.limbs(), big.limbs(), big.size_, small.limbs(), small.size_);
    r.trim(big.size_);
  }
  return r;
}

BigInt BigInt::operator*(const BigInt& b) const {
  BigInt r;
  if (size_ == 0 || b.size_ == 0) return r;
  r.reserve(size_ + b.size_);
  const bool is_long = std::min(size_, b.size_) >= kShort && std::max(size_, b.size_) <= kLongest;
  (is_long ? multiply_long : multiply_limbs)(r.limbs(), limbs(), size_, b.limbs(), b.size_);
  r.negative_ = negative_ != b.negative_;
  r.trim(size_ + b.size_);
  return r;
}

void BigInt::add_product(const BigInt& a, const BigInt& b, bool negate) {
  if (a.size_ == 0 || b.size_ == 0) return;
  const std::uint32_t n = a.size_ + b.size_;
  const bool negative = (a.negative_ != b.negative_) != negate;
  if (n > kInline || size_ > kInline) {
    const BigInt product = a * b;
    accumulate(product.limbs(), product.size_, negative);
    return;
  }
  Limb product[kInline];
  multiply_limbs(product, a.limbs(), a.size_, b.limbs(), b.size_);
  accumulate(product, product[n - 1] == 0 ? n - 1 : n, negative);
}

void BigInt::accumulate(const Limb* other, std::uint32_t n, bool negative) {
  const std::uint32_t most = std::max(size_, n) + 1;
  if (most > capacity_) {
    BigInt larger;
    larger.reserve(most);
    std::copy_n(limbs(), size_, larger.limbs());
    larger.size_ = size_;
    larger.negative_ = negative_;
    *this = std::move(larger);
  }
  Limb* mine = limbs();
  if (size_ == 0) {
    for (std::uint32_t i = 0; i < n; ++i) mine[i] = other[i];
    size_ = n;
    negative_ = negative;
    return;
  }
  if (negative_ == negative) {
    size_ = size_ >= n ? add_limbs(mine, mine, size_, other, n)
                       : add_limbs(mine, other, n, mine, size_);
    return;
  }
  const bool larger = size_ != n ? size_ > n : compare_limbs(mine, other, n) >= 0;
  if (larger) {
    subtract_limbs(mine, mine, size_, other, n);
    trim(size_);
  } else {
    subtract_limbs(mine, other, n, mine, size_);
    negative_ = negative;
    trim(n);
  }
}

BigInt BigInt::operator<<(int bits) const {
  if (size_ == 0 || bits == 0) return *this;
  const auto words = static_cast<std::uint32_t>(bits / 64);
  const int rest = bits % 64;
  BigInt r;
  r.reserve(size_ + words + 1);
  Limb* out = r.limbs();
  const Limb* in = limbs();
  std::fill_n(out, words, Limb{0});
  Limb low = 0;
  for (std::uint32_t i = 0; i < size_; ++i) {
    out[i + words] = (in[i] << rest) | low;
    low = rest == 0 ? 0 : in[i] >> (64 - rest);
  }
  out[size_ + words] = low;
  r.negative_ = negative_;
  r.trim(size_ + words + 1);
  return r;
}

BigInt BigInt::operator>>(int bits) const {
  const auto words = static_cast<std::uint32_t>(bits / 64);
  const int rest = bits % 64;
  BigInt r;
  if (words >= size_) return r;
  const std::uint32_t n = size_ - words;
  r.reserve(n);
  Limb* out = r.limbs();
  const Limb* in = limbs() + words;
  for (std::uint32_t i = 0; i < n; ++i) {
    const Limb high = i + 1 < n && rest != 0 ? in[i + 1] << (64 - rest) : 0;
    out[i] = (in[i] >> rest) | high;
  }
  r.negative_ = negative_;
  r.trim(n);
  return r;
}

int lowest_bit(double x) {
  int e = 0;
  const double m = std::frexp(std::abs(x), &e);
  constexpr int kMantissaBits = 53;
  const auto bits = static_cast<std::uint64_t>(std::ldexp(m, kMantissaBits));
  return e - kMantissaBits + std::countr_zero(bits);
}

}  // namespace selvedge
