// SPDX-License-Identifier: MIT
// The kernels with vectors of eight floats. A pragma compiles only the functions of this file for
// AVX2: a compiler flag would also affect inline functions of the standard library, of which the
// linker keeps one copy for the whole program.
#include <selvedge/core/cloth/detail/lane_matrix.h>

#if defined(__x86_64__) && defined(__GNUC__)

#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif

namespace selvedge::detail {
namespace {
namespace lane_matrix_avx2 {

#define SELVEDGE_MATRIX_FLOATS 8
constexpr int kFloats = SELVEDGE_MATRIX_FLOATS;
#include <selvedge/core/cloth/detail/lane_matrix_kernel.inc>

}  // namespace lane_matrix_avx2
}  // namespace
}  // namespace selvedge::detail

#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

namespace selvedge::detail {

LaneMatrixKernel lane_matrix_kernel_avx2() {
  return __builtin_cpu_supports("avx2") ? lane_matrix_avx2::kernel() : LaneMatrixKernel{};
}

}  // namespace selvedge::detail

#else

namespace selvedge::detail {

LaneMatrixKernel lane_matrix_kernel_avx2() { return {}; }

}  // namespace selvedge::detail

#endif
