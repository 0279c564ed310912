// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <array>
#include <cstdint>
#include <span>

namespace selvedge::detail {

/// Number of queries of one kind that the filter processes together.
inline constexpr int kFilterBlock = 8;
using QueryBlock = std::array<const Query*, kFilterBlock>;

/// Stages A, B and the vectors of stage C for one vector width. Each test returns a mask: bit j is
/// set if the test proves that query j of the block has no collision, or in stage C if it decides
/// the query and has written its time, or kNoCollision, to toi[j]. Either all queries of a block
/// are edge pairs (`edges`) or none is. What is proven does not depend on rounding, so the results
/// are the same bits for each width.
struct FilterKernel {
  using Test = std::uint32_t (*)(const QueryBlock& block, bool edges);
  int width;                                         ///< doubles in a vector
  std::uint32_t (*finite)(const QueryBlock& block);  ///< queries whose coordinates are all finite
  Test separated_on_axes;                            ///< stage A, along x, y and z
  Test separated_on_diagonals;                       ///< stage A, along x+-y, y+-z and z+-x
  Test never_coplanar;                               ///< stage B
  std::uint32_t (*decided_at_simple_roots)(const QueryBlock& block, bool edges,
                                           std::span<double, kFilterBlock> toi);  ///< stage C
};

/// The kernels that the compiler built and the processor supports, narrowest first; never empty.
std::span<const FilterKernel> filter_kernels();

}  // namespace selvedge::detail
