// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/detail/relative_query.h>

namespace selvedge::detail {

/// The vectors from the vertices of the second primitive to those of the first; for a point and a
/// triangle the fourth repeats the third. Both primitives are the hulls of their vertices, so the
/// smallest product with a direction n is the distance of the primitives along n.
using VertexDifferences = std::array<Vec3, 4>;

VertexDifferences vertex_differences(bool edges, const std::array<Vec3, 4>& x);

/// The smallest product with n.
inline double least_along(const Vec3& n, const VertexDifferences& w) {
  return std::min(std::min(n.dot(w[0]), n.dot(w[1])), std::min(n.dot(w[2]), n.dot(w[3])));
}

/// Bound of the error of n . w / |n| for differences of places(), with L2 norms |n| in [1/2, 2], in
/// units of u: each coordinate of w is off by 2 * 5 and one rounding of 2, times sqrt(3) for the
/// three of n: 21; products and sums: 3 * 2 sqrt(3) < 11; |n| and the quotient: 5 * 2 sqrt(3) < 18.
/// The total is 50, plus a reserve for terms in u^2 and underflow.
inline constexpr double kGapError = 64.0 * kRoundoff;

struct SeparatingDirection {
  Vec3 n = Vec3::UnitX();  ///< unit except for rounding
  /// Lower bound of the distance of the primitives, however inaccurate n is: their distance along a
  /// unit vector never exceeds their distance. Negative if no direction was found.
  double distance = -std::numeric_limits<double>::infinity();
};

/// The direction between the closest points. If the primitives are so near that this vector is
/// mostly rounding error, the best of the normals defined by their features, which are accurate at
/// any distance: for well-shaped primitives the bound is below the true distance by a small
/// multiple of kGapError.
SeparatingDirection separating_direction(bool edges, const std::array<Vec3, 4>& x,
                                         const VertexDifferences& w);

}  // namespace selvedge::detail
