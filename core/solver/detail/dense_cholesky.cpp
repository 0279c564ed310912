// SPDX-License-Identifier: MIT
// The factorisation with vectors of two doubles, which every x86-64 supports, and
// of four. The instructions leave out "fma": a fused multiply-add would change the bits.
#include <selvedge/core/base/internal/vector_target.h>
#include <selvedge/core/solver/detail/dense_cholesky.h>

namespace selvedge::detail {
namespace {
namespace narrow {

#define SELVEDGE_CHOLESKY_DOUBLES 2
#include <selvedge/core/solver/detail/dense_cholesky_kernel.inc>
#undef SELVEDGE_CHOLESKY_DOUBLES

}  // namespace narrow

#ifdef SELVEDGE_VECTOR_TARGETS

SELVEDGE_TARGET_BEGIN("avx2")
namespace avx2 {

#define SELVEDGE_CHOLESKY_DOUBLES 4
#include <selvedge/core/solver/detail/dense_cholesky_kernel.inc>
#undef SELVEDGE_CHOLESKY_DOUBLES

}  // namespace avx2
SELVEDGE_TARGET_END

#endif

std::vector<CholeskyKernel> cholesky_kernels_of_this_machine() {
  std::vector<CholeskyKernel> all{narrow::kernel()};
#ifdef SELVEDGE_VECTOR_TARGETS
  if (__builtin_cpu_supports("avx2")) all.push_back(avx2::kernel());
#endif
  return all;
}

}  // namespace

std::span<const CholeskyKernel> cholesky_kernels() {
  static const std::vector<CholeskyKernel> kernels = cholesky_kernels_of_this_machine();
  return kernels;
}

}  // namespace selvedge::detail
