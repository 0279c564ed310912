// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <span>
#include <vector>

namespace selvedge {

/// Square sparse matrix of 3×3 blocks in compressed sparse row form with a fixed pattern; the
/// diagonal blocks are always present. Both triangles are stored so that y = A x runs in parallel
/// by rows.
class BlockMatrix {
 public:
  BlockMatrix() = default;
  /// `links` lists the index pairs (i, j), i != j, for which blocks (i,j) and (j,i) exist.
  BlockMatrix(std::size_t n, std::vector<Edge> links);

  std::size_t size() const { return row_begin_.empty() ? 0 : row_begin_.size() - 1; }
  void set_zero();
  /// Sets the rows [first, last) to zero.
  void set_zero(std::size_t first, std::size_t last);
  /// Position of block (i, j) in the value array. Throws std::out_of_range if the block is absent.
  /// Intended for set-up, not for inner loops.
  std::int32_t slot(std::int32_t i, std::int32_t j) const;
  std::span<Mat3> values() { return values_; }
  std::span<const Mat3> values() const { return values_; }
  const Mat3& diagonal(std::size_t i) const { return values_[diagonal_[i]]; }
  Mat3& diagonal(std::size_t i) { return values_[diagonal_[i]]; }
  /// The pattern: row i has the blocks [row_begin[i], row_begin[i+1]), with ascending columns.
  std::span<const std::int32_t> row_begin() const { return row_begin_; }
  std::span<const std::int32_t> columns() const { return column_; }
  /// y = A x. Multi-threaded; deterministic.
  void multiply(std::span<const Vec3> x, std::span<Vec3> y) const;

 private:
  std::vector<std::int32_t> row_begin_, column_, diagonal_;
  std::vector<Mat3> values_;
};

}  // namespace selvedge
