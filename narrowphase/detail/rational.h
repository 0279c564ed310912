// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace selvedge::narrowphase_detail {

enum class RationalFault {
  none,
  numerator,         ///< is no integer
  denominator,       ///< is no integer
  zero_denominator,  ///< the quotient is no number
  too_long,          ///< more than kMaxDigits digits
  no_double,         ///< no double equals the quotient
};

/// Nothing that doubles lead to is a hundredth as long; bounds the time that a damaged file takes.
inline constexpr std::size_t kMaxDigits = 100'000;

/// The double that equals num / den, both decimal integers with or without a sign. Exact or
/// refused, never rounded.
RationalFault parse_rational(std::string_view num, std::string_view den, double& value);

/// Appends "num,den" of a finite double, den a power of two: parse_rational gives back the same
/// bits, the sign of zero included.
void append_rational(double value, std::string& text);

}  // namespace selvedge::narrowphase_detail
