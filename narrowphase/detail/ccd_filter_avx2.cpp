// SPDX-License-Identifier: MIT
// The filter with vectors of four doubles. A pragma compiles only the functions of this file for
// AVX2 and FMA. A compiler flag would also affect the standard library's inline functions, of which
// the linker keeps one copy for the whole program.
#include <selvedge/narrowphase/detail/ccd_filter.h>
#include <selvedge/narrowphase/detail/error_bounds.h>

#if defined(__x86_64__) && defined(__GNUC__)

#include <immintrin.h>

#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,fma")
#endif

namespace selvedge::narrowphase_detail::avx2 {
namespace {

#define SELVEDGE_FILTER_LANES 4
constexpr int kLanes = SELVEDGE_FILTER_LANES;
#include <selvedge/narrowphase/detail/ccd_filter_kernel.inc>
#include <selvedge/narrowphase/detail/ccd_root_kernel.inc>

}  // namespace
}  // namespace selvedge::narrowphase_detail::avx2

#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

namespace selvedge::narrowphase_detail {

FilterKernel filter_kernel_avx2() {
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return {};
  return {avx2::kLanes,
          avx2::finite,
          avx2::separated_on_axes,
          avx2::separated_on_diagonals,
          avx2::never_coplanar,
          avx2::decided_at_simple_roots};
}

}  // namespace selvedge::narrowphase_detail

#else

namespace selvedge::narrowphase_detail {

FilterKernel filter_kernel_avx2() { return {}; }

}  // namespace selvedge::narrowphase_detail

#endif
