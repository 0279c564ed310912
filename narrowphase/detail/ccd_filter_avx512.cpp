// SPDX-License-Identifier: MIT
// The filter with vectors of eight doubles. A pragma compiles only the functions of this file for
// AVX-512. A compiler flag would also affect the standard library's inline functions, of which the
// linker keeps one copy for the whole program.
#include <selvedge/narrowphase/detail/ccd_filter.h>
#include <selvedge/narrowphase/detail/error_bounds.h>

#if defined(__x86_64__) && defined(__GNUC__)

#include <immintrin.h>

#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx512f"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx512f")
#endif

namespace selvedge::narrowphase_detail::avx512 {
namespace {

#define SELVEDGE_FILTER_LANES 8
constexpr int kLanes = SELVEDGE_FILTER_LANES;
#include <selvedge/narrowphase/detail/ccd_filter_kernel.inc>
#include <selvedge/narrowphase/detail/ccd_root_kernel.inc>

}  // namespace
}  // namespace selvedge::narrowphase_detail::avx512

#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

namespace selvedge::narrowphase_detail {

FilterKernel filter_kernel_avx512() {
  if (!__builtin_cpu_supports("avx512f")) return {};
  return {avx512::kLanes,
          avx512::finite,
          avx512::separated_on_axes,
          avx512::separated_on_diagonals,
          avx512::never_coplanar,
          avx512::decided_at_simple_roots};
}

}  // namespace selvedge::narrowphase_detail

#else

namespace selvedge::narrowphase_detail {

FilterKernel filter_kernel_avx512() { return {}; }

}  // namespace selvedge::narrowphase_detail

#endif
