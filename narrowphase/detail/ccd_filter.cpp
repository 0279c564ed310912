// SPDX-License-Identifier: MIT
// The filter with vectors of two doubles: SSE2 on x86-64; elsewhere the compiler chooses the
// instructions.
#include <selvedge/narrowphase/detail/ccd_filter.h>
#include <selvedge/narrowphase/detail/error_bounds.h>

#include <vector>

#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace selvedge::narrowphase_detail {
namespace narrow {
namespace {

#define SELVEDGE_FILTER_LANES 2
constexpr int kLanes = SELVEDGE_FILTER_LANES;
#include <selvedge/narrowphase/detail/ccd_filter_kernel.inc>
#include <selvedge/narrowphase/detail/ccd_root_kernel.inc>

}  // namespace
}  // namespace narrow

FilterKernel filter_kernel_narrow() {
  return {narrow::kLanes,
          narrow::finite,
          narrow::separated_on_axes,
          narrow::separated_on_diagonals,
          narrow::never_coplanar,
          narrow::decided_at_simple_roots};
}

std::span<const FilterKernel> filter_kernels() {
  static const std::vector<FilterKernel> kernels = [] {
    std::vector<FilterKernel> found{filter_kernel_narrow()};
    for (const FilterKernel& kernel : {filter_kernel_avx2(), filter_kernel_avx512()})
      if (kernel.finite != nullptr) found.push_back(kernel);
    return found;
  }();
  return kernels;
}

}  // namespace selvedge::narrowphase_detail
