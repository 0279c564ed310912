// SPDX-License-Identifier: MIT
#pragma once

namespace selvedge::detail {

/// Unit roundoff u of double.
inline constexpr double kRoundoff = 0x1p-53;

/// Stages B and C handle queries whose largest differences lie in this range. Products of three of
/// them then neither overflow nor lose more to underflow (2^-1074 against at least 2^-800 * u) than
/// the reserve in the bounds covers.
inline constexpr double kSmallest = 0x1p-260, kLargest = 0x1p260;

/// Bound of |computed - exact| of the coefficients of the coplanarity cubic, in units of u * max|X|
/// * max|Y| * max|Z| (coordinates of the computed differences). Each coefficient is a sum of at
/// most 18 products of three differences. Each product undergoes 3 roundings of differences, 2 of
/// products and at most 5 of sums: 18 * 10 = 180. The rest is a reserve for terms of order u^2, for
/// computing the bound itself and for underflow.
inline constexpr double kCubicError = 192.0;

/// Bound of the error of a value of the cubic computed from these coefficients, in the same unit:
/// that of the coefficients, and at most 10 roundings in the value, in Bernstein form, on terms
/// whose sum is at most 6.
inline constexpr double kCubicValueError = 256.0;

/// Bound of the error of the cubic's slope, in the same unit. Its Bernstein coefficients c1 - 3 c0,
/// c2 - c1 and 3 c3 - c2 are at most 36. With the errors of c and one or two roundings of its own,
/// each is off by at most 192 + 192 + 54. The value takes 6 roundings more.
inline constexpr double kSlopeError = 1024.0;

/// Bound of the error of n . Z from the differences at one time, in the same unit. A difference is
/// off by at most 4, a component of n by 2 (4 + 4 + 1) + 2 = 20, its product with Z, at most 2, by
/// 20 + 2 * 4 + 2; the sum of the three takes 2 roundings of at most 6.
inline constexpr double kPlaceCubicError = 128.0;

/// Bound of the error of the Bernstein coefficients f(0), c1/3, c2/3, f(1) in the unit of
/// kCubicError: 6 terms with 8 roundings each for the outer ones; a third of 180 and one rounding
/// of at most 6 for the inner ones; and a reserve.
inline constexpr double kBernsteinError = 96.0;

/// Bound of the error of n_i or a constraint on a box, in units of u times the products of the
/// largest differences in it: |X||Y| for n, |Z||Y| for h, |X||Z| for g, their sum for a sum of
/// these. A product of two differences takes 3 roundings and is at most 1; a coefficient of a cross
/// product, the mean of 4 products and at most 2, takes 2 more: 10. Summing three of them takes 2
/// roundings: 4 more for each. The value on a box is a mean of three such coefficients with at most
/// 8 roundings: 16. The total is 30, plus a reserve.
inline constexpr double kConstraintError = 48.0;

/// Bound of the error of the cubic in double-double, in units of the product of the largest
/// differences. Each coefficient is a sum of at most 18 products of size 1 that go through at most
/// 10 operations, and the value at t adds at most 9 operations on terms whose sum is at most 18:
/// 18 * (10 + 9) * 7 < 2^12 units of 2^-106.
inline constexpr double kSharpCubicError = 0x1p-94;

/// A root is narrowed to this part of its distance from the double below it.
inline constexpr double kLocated = 0x1p-20;

/// Bound of the error of n_i or a constraint at one time in double-double, in the units of
/// kConstraintError without u: a coordinate takes 4 operations, a product of two of them, at most
/// 1, takes 9, their difference 10, and two sums 2 more: 2 * 12 * 7 < 2^8 units of 2^-106.
inline constexpr double kSharpConstraintError = 0x1p-98;
/// Bound of the change of n_i or a constraint per unit of time, in the same units: X and Y each
/// change by at most 2, two products of them by 8.
inline constexpr double kConstraintSlope = 8.0;

}  // namespace selvedge::detail
