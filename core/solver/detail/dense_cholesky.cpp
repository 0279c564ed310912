// SPDX-License-Identifier: MIT
// Four columns at a time: tiles of some rows and four columns lose the products of all earlier
// columns, then the columns of the block those of each other. Each element is
// ((a_ij - l_i0 l_j0) - l_i1 l_j1) - ..., divided by l_jj at the end, whatever the tiles are.
#include <selvedge/core/solver/detail/dense_cholesky.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace selvedge::detail {
namespace {

constexpr std::size_t kTile = 4;     // columns
constexpr std::size_t kTallest = 8;  // rows of a tile of the widest kernel

}  // namespace

void DenseCholesky::set_zero(std::size_t n) {
  size_ = n;
  stride_ = (n + kTallest - 1) / kTallest * kTallest;
  values_.assign(stride_ * stride_, 0.0);
  inverse_.assign(n, 0.0);
  rows_.resize(kTile * n);
}

/// Factors the columns of the block that begins at `column`, from which earlier ones are
/// subtracted.
void DenseCholesky::factor_block(std::size_t column) {
  for (std::size_t j = column; j < std::min(column + kTile, size_); ++j) {
    double* own = values_.data() + j * stride_;
    for (std::size_t k = column; k < j; ++k) {
      const double* earlier = values_.data() + k * stride_;
      const double by = earlier[j];
      for (std::size_t i = j; i < stride_; ++i) own[i] -= earlier[i] * by;
    }
    const double pivot = own[j];
    inverse_[j] = pivot > 0.0 ? 1.0 / std::sqrt(pivot) : 0.0;
    const double inverse = inverse_[j];
    for (std::size_t i = j; i < stride_; ++i) own[i] *= inverse;
  }
}

void DenseCholesky::factor(CholeskyKernel subtract_earlier) {
  for (std::size_t column = 0; column < size_; column += kTile) {
    // the block's own rows of the earlier columns, one column after the other
    for (std::size_t k = 0; k < column; ++k)
      std::copy_n(values_.data() + k * stride_ + column, kTile, rows_.data() + kTile * k);
    subtract_earlier(values_.data(), stride_, column, rows_.data());
    factor_block(column);
  }
}

void DenseCholesky::solve(double* b) const {
  for (std::size_t j = 0; j < size_; ++j) {
    const double* column = values_.data() + j * stride_;
    const double x = b[j] *= inverse_[j];
    for (std::size_t i = j + 1; i < size_; ++i) b[i] -= column[i] * x;
  }
  for (std::size_t j = size_; j-- > 0;) {
    const double* column = values_.data() + j * stride_;
    std::array<double, kTile> sums{};  // of every fourth product
    std::size_t i = j + 1;
    for (; i + kTile <= size_; i += kTile)
      for (std::size_t c = 0; c < kTile; ++c) sums[c] += column[i + c] * b[i + c];
    for (std::size_t c = 0; i < size_; ++i, ++c) sums[c] += column[i] * b[i];
    b[j] = (b[j] - ((sums[0] + sums[1]) + (sums[2] + sums[3]))) * inverse_[j];
  }
}

}  // namespace selvedge::detail
