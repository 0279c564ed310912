// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

/// Eigen's solvers for dense matrices, compiled once for all tests.
namespace selvedge::testing {

/// Eigenvalues of a symmetric matrix, ascending.
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a);

/// The solution x of a x = b, by LU decomposition with partial pivoting.
Eigen::VectorXd solve_dense(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

}  // namespace selvedge::testing
