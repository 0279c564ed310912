// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

namespace selvedge {

/// Signed integer of any size for the exact stage. Numbers of up to kInline * 64 bits, enough for
/// the coordinates of ordinary scenes, live in the object; larger ones on the heap.
class BigInt {
 public:
  BigInt() = default;
  explicit BigInt(std::int64_t value);
  BigInt(const BigInt& other);
  BigInt(BigInt&& other) noexcept;
  BigInt& operator=(const BigInt& other);
  BigInt& operator=(BigInt&& other) noexcept;
  ~BigInt() { release(); }

  /// The double times 2^-exponent; the caller guarantees that this is an integer.
  static BigInt from_double(double value, int exponent);

  int sign() const { return size_ == 0 ? 0 : (negative_ ? -1 : 1); }
  bool is_zero() const { return size_ == 0; }
  /// Position after the highest set bit of the magnitude; 0 for 0.
  int bit_length() const;
  /// Number of trailing zero bits of the magnitude; 0 for 0.
  int trailing_zeros() const;
  /// Mantissa in [0.5, 1) with the sign, such that the number is about mantissa * 2^exponent;
  /// truncated, relative error below 2^-52.
  double mantissa(int& exponent) const;
  /// The same with the next 53 bits in `rest`: mantissa + rest, with the same exponent, has a
  /// relative error below 2^-105.
  double mantissa(int& exponent, double& rest) const;

  BigInt operator-() const;
  BigInt operator+(const BigInt& b) const { return add(*this, b, b.negative_); }
  BigInt operator-(const BigInt& b) const { return add(*this, b, !b.negative_); }
  BigInt operator*(const BigInt& b) const;
  /// *this += a * b, or -= if `negate`; a and b must be other objects.
  void add_product(const BigInt& a, const BigInt& b, bool negate = false);
  BigInt operator<<(int bits) const;
  /// Shift of the magnitude, rounding towards zero.
  BigInt operator>>(int bits) const;
  bool is_odd() const { return size_ > 0 && (limbs()[0] & 1U) != 0; }

 private:
  static constexpr std::uint32_t kInline = 10;

  static BigInt add(const BigInt& a, const BigInt& b, bool b_negative);
  static int compare_magnitude(const BigInt& a, const BigInt& b);

  const std::uint64_t* limbs() const { return capacity_ > kInline ? heap_ : inline_; }
  std::uint64_t* limbs() { return capacity_ > kInline ? heap_ : inline_; }
  /// *this += sign * (limbs of length n).
  void accumulate(const std::uint64_t* other, std::uint32_t n, bool negative);
  /// Makes room for n limbs; discards the old ones.
  void reserve(std::uint32_t n);
  void release() {
    if (capacity_ > kInline) give_back();
    capacity_ = kInline;
  }
  void give_back();
  void trim(std::uint32_t n);

  std::uint32_t size_ = 0;
  std::uint32_t capacity_ = kInline;
  bool negative_ = false;
  union {
    std::uint64_t inline_[kInline];
    std::uint64_t* heap_;
  };
};

/// Exponent of the lowest set bit of x, which is finite and not zero.
int lowest_bit(double x);

}  // namespace selvedge
