// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/force.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// The elements of a force by the blocks of the Jacobian to which they add. Each block sums its
/// elements in their order, in registers. So blocks can be summed in parallel, memory is written
/// once and in order, and the result does not depend on the number of threads.
struct BlockElements {
  std::vector<std::uint32_t> begin{0};  ///< per block with elements, plus one: its first entry
  std::vector<std::int32_t> slot;       ///< per block with elements: its place in the matrix
  /// arity²·element + arity·i + j, where corner i is at the row of the block, j at its column.
  std::vector<std::uint32_t> entry;

  std::size_t size() const { return slot.size(); }
};

/// `particle_of`: the corners of the elements, `arity` each.
BlockElements blocks_of(std::span<const std::int32_t> particle_of, std::size_t arity,
                        const BlockMatrix& matrix);

}  // namespace selvedge::detail
