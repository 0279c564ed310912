// SPDX-License-Identifier: MIT
// The kernels of the matrix with vectors of four floats, which every x86-64 supports, and of eight.
#include <selvedge/core/base/internal/vector_target.h>
#include <selvedge/core/cloth/detail/lane_matrix.h>

namespace selvedge::detail {
namespace {
namespace narrow {

#define SELVEDGE_MATRIX_FLOATS 4
#include <selvedge/core/cloth/detail/lane_matrix_kernel.inc>
#undef SELVEDGE_MATRIX_FLOATS

}  // namespace narrow

#ifdef SELVEDGE_VECTOR_TARGETS

SELVEDGE_TARGET_BEGIN("avx2")
namespace avx2 {

#define SELVEDGE_MATRIX_FLOATS 8
#include <selvedge/core/cloth/detail/lane_matrix_kernel.inc>
#undef SELVEDGE_MATRIX_FLOATS

}  // namespace avx2
SELVEDGE_TARGET_END

#endif

std::vector<LaneMatrixKernel> matrix_kernels_of_this_machine() {
  std::vector<LaneMatrixKernel> all{narrow::kernel()};
#ifdef SELVEDGE_VECTOR_TARGETS
  if (__builtin_cpu_supports("avx2")) all.push_back(avx2::kernel());
#endif
  return all;
}

}  // namespace

std::span<const LaneMatrixKernel> lane_matrix_kernels() {
  static const std::vector<LaneMatrixKernel> kernels = matrix_kernels_of_this_machine();
  return kernels;
}

const LaneMatrixKernel& lane_matrix_kernel() {
  static const LaneMatrixKernel widest = lane_matrix_kernels().back();
  return widest;
}

}  // namespace selvedge::detail
