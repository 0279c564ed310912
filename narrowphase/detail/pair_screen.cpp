// SPDX-License-Identifier: MIT
// The screen with vectors of four floats: SSE2 on x86-64; elsewhere the compiler chooses the
// instructions.
#include <selvedge/narrowphase/detail/pair_screen.h>

#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace selvedge::narrowphase_detail {
namespace narrow_screen {
namespace {

#define SELVEDGE_SCREEN_LANES 4
constexpr int kLanes = SELVEDGE_SCREEN_LANES;
#include <selvedge/narrowphase/detail/pair_screen_kernel.inc>

}  // namespace
}  // namespace narrow_screen

Screen screen_narrow() { return {narrow_screen::compare, narrow_screen::never_meet}; }

const Screen& best_screen() {
  static const Screen best = screen_avx2().compare != nullptr ? screen_avx2() : screen_narrow();
  return best;
}

}  // namespace selvedge::narrowphase_detail
