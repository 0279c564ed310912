// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace selvedge::detail {

enum class RationalFault {
  none,
  numerator,         ///< is not an integer
  denominator,       ///< is not an integer
  zero_denominator,  ///< the quotient is undefined
  too_long,          ///< more than kMaxDigits digits
  no_double,         ///< no double equals the quotient
};

/// More than a hundred times the length that a double needs; limits the time that a damaged file
/// can take.
inline constexpr std::size_t kMaxDigits = 100'000;

/// The double that equals num / den, two decimal integers with or without a sign. The result is
/// exact, or the input is rejected; it is never rounded.
RationalFault parse_rational(std::string_view num, std::string_view den, double& value);

/// Appends "num,den" for a finite double, where den is a power of two. parse_rational returns the
/// same bits, including the sign of zero.
void append_rational(double value, std::string& text);

}  // namespace selvedge::detail
