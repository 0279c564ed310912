// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <array>
#include <cstdint>
#include <span>

namespace selvedge::narrowphase_detail {

/// Queries of one kind that the filter looks at together.
inline constexpr int kFilterBlock = 8;
using QueryBlock = std::array<const Query*, kFilterBlock>;

/// The filter of stages A and B for one vector width. Each test returns a mask, bit j for query j
/// of the block: set where it proves that there is no collision. All queries of a block are edge
/// pairs if `edges`, else none is. Every kernel makes the same operations in the same order, so
/// that the verdicts are the same bits.
struct FilterKernel {
  using Test = std::uint32_t (*)(const QueryBlock& block, bool edges);
  int width;                                         ///< doubles in a vector
  std::uint32_t (*finite)(const QueryBlock& block);  ///< where all coordinates are
  Test separated_on_axes;                            ///< stage A, along x, y and z
  Test separated_on_diagonals;                       ///< stage A, along x+-y, y+-z and z+-x
  Test never_coplanar;                               ///< stage B
};

/// The kernels that the compiler made and the processor runs, narrowest first; never empty.
std::span<const FilterKernel> filter_kernels();

// One of each width; the functions are null where the compiler or the processor has none.
FilterKernel filter_kernel_narrow();
FilterKernel filter_kernel_avx2();
FilterKernel filter_kernel_avx512();

}  // namespace selvedge::narrowphase_detail
