// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/detail/block_elements.h>
#include <selvedge/core/cloth/detail/lane_forces.h>
#include <selvedge/core/cloth/force.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// A kind of elements whose Jacobian is summed by blocks.
struct BlockKind {
  std::size_t arity;                ///< corners of an element
  std::size_t numbers;              ///< per element, from which its blocks follow
  std::size_t grain;                ///< groups per task of finding them
  ElementParts LaneKernel::*parts;  ///< finds them
  AddBlocks LaneKernel::*blocks;    ///< adds blocks
};
inline constexpr BlockKind kSpringKind{2, kSpringParts, 256, &LaneKernel::spring_parts,
                                       &LaneKernel::spring_blocks};
inline constexpr BlockKind kHingeKind{4, kHingeParts, 128, &LaneKernel::hinge_parts,
                                      &LaneKernel::hinge_blocks};

/// The Jacobian of a force by blocks: where its elements add to the matrix, and a few numbers of
/// each element. A first pass finds the numbers, a second one sums the blocks from them.
class BlockJacobian final : public JacobianRows {
 public:
  explicit BlockJacobian(const BlockKind& kind) : kind_(kind) {}

  /// `particle_of`: the corners of the elements.
  void bind(std::span<const std::int32_t> particle_of, const BlockMatrix& matrix);
  /// The first pass, for the Jacobian -h ∂f/∂v - h² ∂f/∂x.
  void find_numbers(const LaneGroups& lanes, const LaneForce& force, double h);
  void add_rows(std::size_t first, std::size_t last, BlockMatrix& a) const override;
  /// Adds all rows.
  void add(BlockMatrix& a) const;

 private:
  BlockKind kind_;
  BlockElements blocks_;
  std::vector<double> numbers_;
};

}  // namespace selvedge::detail
