// SPDX-License-Identifier: MIT
// Four columns at a time: tiles of four rows and four columns lose the products of all earlier
// columns, then the columns of the block those of each other. Each element is
// ((a_ij - l_i0 l_j0) - l_i1 l_j1) - ..., divided by l_jj at the end, whatever the tiles are.
#include <selvedge/core/solver/detail/dense_cholesky.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace selvedge::detail {
namespace {

constexpr std::size_t kTile = 4;
using Two = double __attribute__((vector_size(16)));

/// Four rows of a column.
struct Four {
  Two low, high;
};

Four load(const double* from) {
  Four v;
  std::memcpy(&v, from, sizeof v);
  return v;
}

void store(double* to, const Four& v) { std::memcpy(to, &v, sizeof v); }

}  // namespace

void DenseCholesky::set_zero(std::size_t n) {
  size_ = n;
  stride_ = (n + kTile - 1) / kTile * kTile;
  values_.assign(stride_ * stride_, 0.0);
  inverse_.assign(n, 0.0);
  rows_.resize(kTile * n);
}

/// Subtracts the products of the columns before `column` from the block that begins there.
void DenseCholesky::subtract_earlier(std::size_t column) {
  double* block = values_.data() + column * stride_;
  // the block's own rows of the earlier columns, one column after the other
  for (std::size_t k = 0; k < column; ++k)
    store(rows_.data() + kTile * k, load(values_.data() + k * stride_ + column));
  for (std::size_t i = column; i < stride_; i += kTile) {
    std::array<Four, kTile> tile;
    for (std::size_t c = 0; c < kTile; ++c) tile[c] = load(block + c * stride_ + i);
    for (std::size_t k = 0; k < column; ++k) {
      const Four rows = load(values_.data() + k * stride_ + i);
      const double* by = rows_.data() + kTile * k;
      for (std::size_t c = 0; c < kTile; ++c) {
        tile[c].low -= rows.low * by[c];
        tile[c].high -= rows.high * by[c];
      }
    }
    for (std::size_t c = 0; c < kTile; ++c) store(block + c * stride_ + i, tile[c]);
  }
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

void DenseCholesky::factor() {
  for (std::size_t column = 0; column < size_; column += kTile) {
    subtract_earlier(column);
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
