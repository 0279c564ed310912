// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/types.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// A matrix of 3×3 block rows with a fixed pattern, columns ascending.
struct BlockRows {
  std::vector<std::int32_t> begin, column, diagonal;
  std::vector<Mat3> value;
  std::size_t size() const { return begin.empty() ? 0 : begin.size() - 1; }
};

/// Scalar weights of the parents of each child (at least one), and the children of each parent.
struct Prolongation {
  std::vector<std::int32_t> begin, parent;
  std::vector<double> weight;
  std::vector<std::int32_t> child_begin, child, child_entry;  // entry: index into `weight`
  std::size_t parents() const { return child_begin.size() - 1; }
};

/// Smoothed aggregation on the graph of a matrix pattern.
Prolongation make_prolongation(std::span<const std::int32_t> begin,
                               std::span<const std::int32_t> column);

/// A 3×3 block in single precision; its columns are padded to four numbers for vector units.
struct alignas(16) Block4 {
  float at[12];
};

/// The Galerkin product Pᵀ A P with precomputed patterns: first A P by fine rows, then Pᵀ (A P) by
/// coarse rows, in single precision. Every sum has a fixed order.
class GalerkinProduct {
 public:
  /// Computes the patterns and sets the pattern of `coarse`.
  void set_pattern(std::span<const std::int32_t> begin, std::span<const std::int32_t> column,
                   const Prolongation& p, BlockRows& coarse);
  /// coarse = Pᵀ A P, without the rows and columns of held children.
  void compute(std::span<const std::int32_t> begin, std::span<const std::int32_t> column,
               std::span<const Mat3> value, const Prolongation& p, std::span<const char> free,
               BlockRows& coarse);

 private:
  void set_coarse_pattern(const Prolongation& p, BlockRows& coarse);
  void multiply_right(std::span<const std::int32_t> begin, std::span<const std::int32_t> column,
                      std::span<const Mat3> value, const Prolongation& p,
                      std::span<const char> free);
  void multiply_left(const Prolongation& p, std::span<const char> free, BlockRows& coarse);

  std::vector<std::int32_t> half_begin_, half_column_;  // pattern of A P
  std::vector<Block4> half_, sum_;                      // A P, and the coarse blocks
  std::vector<std::int32_t> half_slot_, coarse_slot_;   // target of each product
  std::vector<std::size_t> half_slot_begin_, coarse_slot_begin_;
};

}  // namespace selvedge::detail
