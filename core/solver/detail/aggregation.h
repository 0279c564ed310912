// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>
#include <selvedge/core/cloth/detail/lane_forces.h>

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

/// The Galerkin product Pᵀ A P with precomputed patterns: first A P, then Pᵀ (A P). Every sum has a
/// fixed order.
class GalerkinProduct {
 public:
  /// Computes the patterns and sets the pattern of `coarse`.
  void set_pattern(std::span<const std::int32_t> begin, std::span<const std::int32_t> column,
                   const Prolongation& p, BlockRows& coarse);
  /// coarse = Pᵀ A P, without the rows and columns of held children. An empty `free` means that
  /// none is held.
  void compute(std::span<const Mat3> value, const Prolongation& p, std::span<const char> free,
               BlockRows& coarse, const LaneKernel& kernel = lane_kernel());

 private:
  /// A product, and the block to which it is added.
  struct Product {
    std::int32_t target;
    std::uint32_t source, weight_of;
  };
  /// The products of which each block is the sum: block `source` times weight `weight_of`.
  struct Sums {
    std::vector<std::uint32_t> begin{0}, source, weight_of;
    std::size_t size() const { return begin.size() - 1; }
    /// Appends the blocks up to `last` from their products, which keep their order.
    void add(std::span<const Product> products, std::size_t last);
    void shrink_to_fit();
  };
  static void compute_sums(const Sums& sums, std::span<const double> weight,
                           std::span<const Mat3> from, std::span<Mat3> to,
                           const LaneKernel& kernel);
  void set_coarse_pattern(const Prolongation& p, BlockRows& coarse);

  std::vector<std::int32_t> half_begin_, half_column_;  // pattern of A P
  std::vector<Mat3> half_;                              // A P
  Sums half_sums_, coarse_sums_;
  std::vector<double> weight_;  // of P; 0 for held children
};

}  // namespace selvedge::detail
