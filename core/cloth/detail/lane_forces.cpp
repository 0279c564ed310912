// SPDX-License-Identifier: MIT
// The forces with vectors of two doubles, which every x86-64 supports, and the list of kernels.
#include <selvedge/core/cloth/detail/lane_forces.h>

#include <cmath>
#include <cstring>
#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace selvedge::detail {
namespace {
namespace narrow {

#define SELVEDGE_FORCE_LANES 2
constexpr int kLanes = SELVEDGE_FORCE_LANES;
#include <selvedge/core/cloth/detail/lane_forces_kernel.inc>

}  // namespace narrow

std::vector<LaneKernel> kernels_of_this_machine() {
  std::vector<LaneKernel> all{narrow::kernel()};
  for (const LaneKernel& wide : {lane_kernel_avx2(), lane_kernel_avx512()})
    if (wide.width > 0) all.push_back(wide);
  return all;
}

}  // namespace

std::span<const LaneKernel> lane_kernels() {
  static const std::vector<LaneKernel> kernels = kernels_of_this_machine();
  return kernels;
}

const LaneKernel& lane_kernel() { return lane_kernels().back(); }

}  // namespace selvedge::detail
