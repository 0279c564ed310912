// SPDX-License-Identifier: MIT
// The filter with vectors of two doubles (SSE2 on x86-64; elsewhere the compiler chooses the
// instructions), four and eight.
#include <selvedge/core/base/internal/vector_target.h>
#include <selvedge/narrowphase/detail/ccd_filter.h>
#include <selvedge/narrowphase/detail/error_bounds.h>

#include <vector>

#ifdef SELVEDGE_VECTOR_TARGETS
#include <immintrin.h>
#endif

namespace selvedge::detail {
namespace {
namespace narrow {

#define SELVEDGE_FILTER_LANES 2
#include <selvedge/narrowphase/detail/ccd_filter_kernel.inc>
#include <selvedge/narrowphase/detail/ccd_root_kernel.inc>
#undef SELVEDGE_FILTER_LANES

}  // namespace narrow

#ifdef SELVEDGE_VECTOR_TARGETS

SELVEDGE_TARGET_BEGIN("avx2,fma")
namespace avx2 {

#define SELVEDGE_FILTER_LANES 4
#include <selvedge/narrowphase/detail/ccd_filter_kernel.inc>
#include <selvedge/narrowphase/detail/ccd_root_kernel.inc>
#undef SELVEDGE_FILTER_LANES

}  // namespace avx2
SELVEDGE_TARGET_END

SELVEDGE_TARGET_BEGIN("avx512f")
namespace avx512 {

#define SELVEDGE_FILTER_LANES 8
#include <selvedge/narrowphase/detail/ccd_filter_kernel.inc>
#include <selvedge/narrowphase/detail/ccd_root_kernel.inc>
#undef SELVEDGE_FILTER_LANES

}  // namespace avx512
SELVEDGE_TARGET_END

#endif

std::vector<FilterKernel> filters_of_this_machine() {
  std::vector<FilterKernel> all{narrow::kernel()};
#ifdef SELVEDGE_VECTOR_TARGETS
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    all.push_back(avx2::kernel());
  if (__builtin_cpu_supports("avx512f")) all.push_back(avx512::kernel());
#endif
  return all;
}

}  // namespace

std::span<const FilterKernel> filter_kernels() {
  static const std::vector<FilterKernel> kernels = filters_of_this_machine();
  return kernels;
}

}  // namespace selvedge::detail
