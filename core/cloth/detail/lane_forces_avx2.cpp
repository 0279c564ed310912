// SPDX-License-Identifier: MIT
// The forces with vectors of four doubles. A pragma compiles only the functions of this file for
// AVX2: a compiler flag would also affect inline functions of the standard library, of which the
// linker keeps one copy for the whole program.
#include <selvedge/core/cloth/detail/lane_forces.h>

#if defined(__x86_64__) && defined(__GNUC__)

#include <immintrin.h>

#include <cstring>

#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif

namespace selvedge::detail {
namespace {
namespace avx2 {

#define SELVEDGE_FORCE_LANES 4
constexpr int kLanes = SELVEDGE_FORCE_LANES;
#include <selvedge/core/cloth/detail/lane_forces_kernel.inc>

}  // namespace avx2
}  // namespace
}  // namespace selvedge::detail

#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

namespace selvedge::detail {

LaneKernel lane_kernel_avx2() {
  return __builtin_cpu_supports("avx2") ? avx2::kernel() : LaneKernel{};
}

}  // namespace selvedge::detail

#else

namespace selvedge::detail {

LaneKernel lane_kernel_avx2() { return {}; }

}  // namespace selvedge::detail

#endif
