// SPDX-License-Identifier: MIT
// The forces with vectors of two doubles, which every x86-64 supports, of four and of eight.
#include <selvedge/core/base/internal/vector_target.h>
#include <selvedge/core/cloth/detail/lane_forces.h>

#include <cmath>
#include <cstring>

#ifdef SELVEDGE_VECTOR_TARGETS
#include <immintrin.h>
#endif

namespace selvedge::detail {
namespace {
namespace narrow {

#define SELVEDGE_FORCE_LANES 2
#include <selvedge/core/cloth/detail/lane_forces_kernel.inc>
#undef SELVEDGE_FORCE_LANES

}  // namespace narrow

#ifdef SELVEDGE_VECTOR_TARGETS

SELVEDGE_TARGET_BEGIN("avx2")
namespace avx2 {

#define SELVEDGE_FORCE_LANES 4
#include <selvedge/core/cloth/detail/lane_forces_kernel.inc>
#undef SELVEDGE_FORCE_LANES

}  // namespace avx2
SELVEDGE_TARGET_END

SELVEDGE_TARGET_BEGIN("avx512f,avx512dq,avx512vl")
namespace avx512 {

#define SELVEDGE_FORCE_LANES 8
#include <selvedge/core/cloth/detail/lane_forces_kernel.inc>
#undef SELVEDGE_FORCE_LANES

}  // namespace avx512
SELVEDGE_TARGET_END

#endif

std::vector<LaneKernel> kernels_of_this_machine() {
  std::vector<LaneKernel> all{narrow::kernel()};
#ifdef SELVEDGE_VECTOR_TARGETS
  if (__builtin_cpu_supports("avx2")) all.push_back(avx2::kernel());
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl"))
    all.push_back(avx512::kernel());
#endif
  return all;
}

}  // namespace

std::span<const LaneKernel> lane_kernels() {
  static const std::vector<LaneKernel> kernels = kernels_of_this_machine();
  return kernels;
}

const LaneKernel& lane_kernel() { return lane_kernels().back(); }

}  // namespace selvedge::detail
