// SPDX-License-Identifier: MIT
#include <selvedge/core/detail/small_matrix.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace selvedge::detail {

SymmetricEigen symmetric_eigen(const Mat3& m) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(m);
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

Mat3 nearest_rotation(const Mat3& m) {
  const Eigen::JacobiSVD<Mat3, Eigen::NoQRPreconditioner> svd(
      m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 sign = Mat3::Identity();  // a rotation, not a reflection
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) sign(2, 2) = -1.0;
  return svd.matrixU() * sign * svd.matrixV().transpose();
}

Vec3 least_squares(const Mat3& m, const Vec3& b) {
  return m.completeOrthogonalDecomposition().solve(b);
}

Vec3 least_squares(const Eigen::Matrix<double, 6, 3>& m, const Eigen::Matrix<double, 6, 1>& b) {
  return m.completeOrthogonalDecomposition().solve(b);
}

}  // namespace selvedge::detail
