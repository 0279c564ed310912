// SPDX-License-Identifier: MIT
#pragma once

namespace selvedge::narrowphase_detail {

/// Unit roundoff u of double.
inline constexpr double kRoundoff = 0x1p-53;

/// Stages B and C work on queries whose largest differences lie in this range: then products of
/// three of them neither overflow nor lose more to underflow (2^-1074 against at least 2^-800 * u)
/// than the reserve in the bounds covers.
inline constexpr double kSmallest = 0x1p-260, kLargest = 0x1p260;

/// Bound of |computed - exact| of the coefficients of the coplanarity cubic, in units of
/// u * max|X| * max|Y| * max|Z| (coordinates of the computed differences). Each coefficient is a
/// sum of at most 18 products of three differences. On the way of a product into the sum lie 3
/// roundings of differences, 2 of products and at most 5 of sums: 18 * 10 = 180, and the rest is
/// reserve for terms of order u^2, for computing the bound itself and for underflow.
inline constexpr double kCubicError = 192.0;

/// Bound of the error of the Bernstein coefficients f(0), c1/3, c2/3, f(1) in the unit of
/// kCubicError: 6 terms with 8 roundings each for the outer ones, a third of 180 and one rounding
/// of at most 6 for the inner ones, and reserve.
inline constexpr double kBernsteinError = 96.0;

/// Bound of the error of a coefficient of n_i, of a constraint, and of its value on a box, in units
/// of u * M^2 with M = max(|X|, |Y|, |Z|). A product of two differences takes 3 roundings, a
/// coefficient of a cross product (4 products, halved) 4 * 5 / 2 = 10, the sum of three of them
/// 3 * 10 plus 2 roundings of at most 6; the value on a box is a mean of three coefficients of
/// at most 6 with at most 8 roundings: 48. In all 90, and reserve.
inline constexpr double kConstraintError = 128.0;

}  // namespace selvedge::narrowphase_detail
