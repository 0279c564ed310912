// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/detail/relative_query.h>

namespace selvedge::narrowphase_detail {

/// The vectors from the vertices of the second primitive to those of the first; for a point and a
/// triangle the fourth repeats the third. Both primitives are the hulls of their vertices, so along
/// any direction n the least of the products with n is how far the primitives are apart along n.
using VertexDifferences = std::array<Vec3, 4>;

VertexDifferences vertex_differences(bool edges, const std::array<Vec3, 4>& x);

/// The least of the products with n.
inline double least_along(const Vec3& n, const VertexDifferences& w) {
  return std::min(std::min(n.dot(w[0]), n.dot(w[1])), std::min(n.dot(w[2]), n.dot(w[3])));
}

/// Bound of the error of n . w / |n| for differences of places(), in L2 norms |n| in [1/2, 2] and
/// units of u: each coordinate of w is off by 2 * 5 and one rounding of 2, times sqrt(3) for the
/// three of n: 21; products and sums: 3 * 2 sqrt(3) < 11; |n| and the quotient: 5 * 2 sqrt(3) < 18.
/// In all 50, and reserve for terms in u^2 and underflow.
inline constexpr double kGapError = 64.0 * kRoundoff;

struct SeparatingDirection {
  Vec3 n = Vec3::UnitX();  ///< unit up to roundings
  /// Never more than the distance of the primitives, however inaccurate n is: along a unit vector
  /// two points are never further apart than they are. Negative if no direction was found.
  double distance = -std::numeric_limits<double>::infinity();
};

/// The direction of the closest points and, where the primitives are so near that their difference
/// is mostly rounding error, the best of the normals that their features define. Those are accurate
/// at any distance: for well-shaped primitives the bound is short of the true distance by a small
/// multiple of kGapError.
SeparatingDirection separating_direction(bool edges, const std::array<Vec3, 4>& x,
                                         const VertexDifferences& w);

}  // namespace selvedge::narrowphase_detail
