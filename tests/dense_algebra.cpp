// SPDX-License-Identifier: MIT
#include <selvedge/tests/dense_algebra.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace selvedge::testing {

Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigen::VectorXd solve_dense(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.partialPivLu().solve(b);
}

}  // namespace selvedge::testing
