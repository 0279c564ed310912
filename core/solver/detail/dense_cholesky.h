// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Subtracts the products of the columns before `column` from the four columns that begin there,
/// of a matrix by columns of `stride` numbers, a multiple of eight. `rows`: the same four rows of
/// each earlier column.
using CholeskyKernel = void (*)(double* values, std::size_t stride, std::size_t column,
                                const double* rows);

/// Those that this processor supports, the widest last. All give the same bits.
std::span<const CholeskyKernel> cholesky_kernels();

/// A = L Lᵀ of a dense symmetric positive definite matrix, in one fixed order of operations without
/// fused multiply-add, so that the bits do not depend on processor, vector width or cache. (Eigen's
/// factorisation depends on all three.)
class DenseCholesky {
 public:
  /// Sets an n x n matrix of zeros.
  void set_zero(std::size_t n);
  /// Element of the lower half, i >= j. Elements of the upper half have no effect.
  double& operator()(std::size_t i, std::size_t j) { return values_[j * stride_ + i]; }

  /// Factors the matrix in place. An unknown whose pivot is not positive is left out: it stays 0 in
  /// solutions.
  void factor(CholeskyKernel subtract_earlier = cholesky_kernels().back());
  /// Replaces the n numbers b by the solution of A x = b.
  void solve(double* b) const;

  std::size_t bytes() const { return sizeof(double) * size_ * size_; }

 private:
  void factor_block(std::size_t column);

  std::size_t size_ = 0;
  std::size_t stride_ = 0;       // a multiple of eight; rows from size_ on are zero
  std::vector<double> values_;   // by columns
  std::vector<double> inverse_;  // of the diagonal of L; 0: left out
  std::vector<double> rows_;     // scratch of factor
};

}  // namespace selvedge::detail
