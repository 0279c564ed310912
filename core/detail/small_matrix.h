// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/types.h>

#include <Eigen/Core>

namespace selvedge::detail {

// Decompositions of small matrices. Only one source instantiates Eigen's templates for them, which
// take seconds to compile.

/// Eigenvalues in increasing order, and unit eigenvectors as columns.
struct SymmetricEigen {
  Vec3 values;
  Mat3 vectors;
  bool converged;
};
SymmetricEigen symmetric_eigen(const Mat3& m);

/// The rotation R with the largest trace of Rᵀ m: for m = Σ (x - x̄)(p - p̄)ᵀ the one that best takes
/// the points p to x [Kabsch1976].
Mat3 nearest_rotation(const Mat3& m);

/// The x of least norm among those with the least |m x - b|.
Vec3 least_squares(const Mat3& m, const Vec3& b);
Vec3 least_squares(const Eigen::Matrix<double, 6, 3>& m, const Eigen::Matrix<double, 6, 1>& b);

}  // namespace selvedge::detail
