// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/detail/error_bounds.h>
#include <selvedge/narrowphase/narrow_phase.h>

namespace selvedge::detail {

/// A query relative to its first vertex, divided by 2^exponent: that vertex rests at the origin,
/// and the largest coordinate lies in [1/2, 1). Positions far from the world origin and common
/// motion cost no digits: every coordinate is within kRoundoff of its exact value. It comes from
/// one subtraction, which is off by at most u times its result, and the scaling is exact except for
/// bits below 2^-1074.
struct RelativeQuery {
  bool edges = false;
  std::array<Vec3, 4> x_t0, x_t1;
  int exponent = 0;
  bool one_point = false;  ///< all vertices are at one point throughout; nothing else is set then
};

RelativeQuery relative_query(const Query& query);

/// A length in the units of `query`, never less than the true one.
double scaled_up(double length, const RelativeQuery& query);

/// Bounds the error of a coordinate of places(), in units of u: at most 1 for the input, 1 for 1 -
/// t, 1 for the two products, whose factors have the sum 1, and 1 for the sum; the rest is a
/// reserve for terms in u^2.
inline constexpr double kPlaceError = 5.0 * kRoundoff;

/// The positions of the vertices at time t in [0, 1].
std::array<Vec3, 4> places(const RelativeQuery& query, double t);

/// Throws std::invalid_argument unless `length` is finite and not negative.
void require_separation(double length, const char* method);

}  // namespace selvedge::detail
