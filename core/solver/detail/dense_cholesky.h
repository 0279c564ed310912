// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Columns that a factorisation takes at a time.
inline constexpr std::size_t kCholeskyColumns = 4;

/// What a kernel works on: a matrix by columns of `stride` numbers, rows from `size` on zero.
struct CholeskyMatrix {
  std::size_t size, stride;  ///< the stride is a multiple of twice the widest vector
  double* values;
  double* inverse;  ///< of the diagonal of L; 0: left out
  double* rows;     ///< scratch, kCholeskyColumns numbers for each column
};

struct CholeskyKernel {
  void (*factor)(const CholeskyMatrix&);
  void (*solve)(const CholeskyMatrix&, double* b);
};

/// Those that this processor supports, the widest last. All give the same bits.
std::span<const CholeskyKernel> cholesky_kernels();

/// A = L Lᵀ of a dense symmetric positive definite matrix, in one fixed order of operations without
/// fused multiply-add, so that the bits do not depend on processor, vector width or cache. (Eigen's
/// factorisation depends on all three.) Four columns at a time: tiles of some rows and these
/// columns lose the products of all earlier columns, then the columns of the block those of each
/// other. Each element is ((a_ij - l_i0 l_j0) - l_i1 l_j1) - ..., divided by l_jj at the end,
/// whatever the tiles are.
class DenseCholesky {
 public:
  explicit DenseCholesky(const CholeskyKernel& kernel = cholesky_kernels().back())
      : kernel_(kernel) {}

  /// Sets an n x n matrix of zeros.
  void set_zero(std::size_t n) {
    size_ = n;
    stride_ = (n + kTallest - 1) / kTallest * kTallest;
    values_.assign(stride_ * stride_, 0.0);
    inverse_.assign(n, 0.0);
    rows_.resize(kCholeskyColumns * n);
  }
  /// Element of the lower half, i >= j. Elements of the upper half have no effect.
  double& operator()(std::size_t i, std::size_t j) { return values_[j * stride_ + i]; }

  /// Factors the matrix in place. An unknown whose pivot is not positive is left out: it stays 0 in
  /// solutions.
  void factor() { kernel_.factor(matrix()); }
  /// Replaces the n numbers b by the solution of A x = b.
  void solve(double* b) { kernel_.solve(matrix(), b); }

  std::size_t bytes() const { return sizeof(double) * size_ * size_; }

 private:
  static constexpr std::size_t kTallest = 8;  // rows of a tile of the widest kernel

  CholeskyMatrix matrix() {
    return {size_, stride_, values_.data(), inverse_.data(), rows_.data()};
  }

  CholeskyKernel kernel_;
  std::size_t size_ = 0, stride_ = 0;
  std::vector<double> values_, inverse_, rows_;  // of a CholeskyMatrix
};

}  // namespace selvedge::detail
