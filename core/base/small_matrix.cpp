// SPDX-License-Identifier: MIT
#include <selvedge/core/base/types.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace selvedge {

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

Mat3 pseudo_inverse(const Mat3& m, double cut) {
  const SymmetricEigen eigen = symmetric_eigen(m);
  Mat3 inverse = Mat3::Zero();
  for (int k = 0; k < 3; ++k)
    if (eigen.values[k] > cut * eigen.values[2])
      inverse += eigen.vectors.col(k) * eigen.vectors.col(k).transpose() / eigen.values[k];
  return inverse;
}

}  // namespace selvedge
