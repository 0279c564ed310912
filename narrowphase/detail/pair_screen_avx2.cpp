// SPDX-License-Identifier: MIT
// The screen with vectors of eight floats. A pragma compiles only the functions of this file for
// AVX2. A compiler flag would also affect the standard library's inline functions, of which the
// linker keeps one copy for the whole program.
#include <selvedge/narrowphase/detail/pair_screen.h>

#if defined(__x86_64__) && defined(__GNUC__)

#include <immintrin.h>

#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif

namespace selvedge::narrowphase_detail::avx2_screen {
namespace {

#define SELVEDGE_SCREEN_LANES 8
constexpr int kLanes = SELVEDGE_SCREEN_LANES;
#include <selvedge/narrowphase/detail/pair_screen_kernel.inc>

}  // namespace
}  // namespace selvedge::narrowphase_detail::avx2_screen

#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

namespace selvedge::narrowphase_detail {

Screen screen_avx2() {
  if (!__builtin_cpu_supports("avx2")) return {};
  return {avx2_screen::compare, avx2_screen::never_meet};
}

}  // namespace selvedge::narrowphase_detail

#else

namespace selvedge::narrowphase_detail {

Screen screen_avx2() { return {}; }

}  // namespace selvedge::narrowphase_detail

#endif
