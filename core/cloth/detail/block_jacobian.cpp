// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/detail/block_jacobian.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

constexpr std::size_t kJacobianBlockGrain = 4096;  // blocks per task

}  // namespace

void BlockJacobian::bind(std::span<const std::int32_t> particle_of, const BlockMatrix& matrix) {
  blocks_ = blocks_of(particle_of, kind_.arity, matrix);
  numbers_.resize(kind_.numbers * (particle_of.size() / kind_.arity));
}

void BlockJacobian::find_numbers(const LaneGroups& lanes, const LaneForce& force, double h) {
  const ElementParts find = lane_kernel().*kind_.parts;
  parallel_for(lanes.groups.size(), kind_.grain, [&](std::size_t first, std::size_t last) {
    find(force, h, numbers_.data(), first, last);
  });
}

void BlockJacobian::add_rows(std::size_t first, std::size_t last, BlockMatrix& a) const {
  const auto before = [&](std::size_t row) {
    const auto at = std::lower_bound(blocks_.slot.begin(), blocks_.slot.end(), a.row_begin()[row]);
    return static_cast<std::size_t>(at - blocks_.slot.begin());
  };
  (lane_kernel().*kind_.blocks)(lane_jacobian(blocks_, numbers_, a), before(first), before(last));
}

void BlockJacobian::add(BlockMatrix& a) const {
  const LaneJacobian jacobian = lane_jacobian(blocks_, numbers_, a);
  parallel_for(blocks_.size(), kJacobianBlockGrain, [&](std::size_t first, std::size_t last) {
    (lane_kernel().*kind_.blocks)(jacobian, first, last);
  });
}

}  // namespace selvedge::detail
