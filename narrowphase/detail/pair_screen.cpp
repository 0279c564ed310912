// SPDX-License-Identifier: MIT
// The screen with vectors of four floats (SSE2 on x86-64; elsewhere the compiler chooses the
// instructions) and of eight.
#include <selvedge/core/base/internal/vector_target.h>
#include <selvedge/narrowphase/detail/pair_screen.h>

#include <vector>

#ifdef SELVEDGE_VECTOR_TARGETS
#include <immintrin.h>
#endif

namespace selvedge::detail {
namespace {
namespace narrow_screen {

#define SELVEDGE_SCREEN_LANES 4
#include <selvedge/narrowphase/detail/pair_screen_kernel.inc>
#undef SELVEDGE_SCREEN_LANES

}  // namespace narrow_screen

#ifdef SELVEDGE_VECTOR_TARGETS

SELVEDGE_TARGET_BEGIN("avx2")
namespace avx2_screen {

#define SELVEDGE_SCREEN_LANES 8
#include <selvedge/narrowphase/detail/pair_screen_kernel.inc>
#undef SELVEDGE_SCREEN_LANES

}  // namespace avx2_screen
SELVEDGE_TARGET_END

#endif

std::vector<Screen> screens_of_this_machine() {
  std::vector<Screen> all{narrow_screen::kernel()};
#ifdef SELVEDGE_VECTOR_TARGETS
  if (__builtin_cpu_supports("avx2")) all.push_back(avx2_screen::kernel());
#endif
  return all;
}

}  // namespace

std::span<const Screen> screens() {
  static const std::vector<Screen> all = screens_of_this_machine();
  return all;
}

}  // namespace selvedge::detail
