// SPDX-License-Identifier: MIT
// The traversal with vectors of eight floats. The functions of this file alone are compiled for
// AVX2, by pragma: a compiler flag would also reach the standard library's inline functions, of
// which the linker keeps one copy for the whole program.
#include <selvedge/broadphase/detail/traverse.h>

#include <array>
#include <bit>

#if (defined(__x86_64__) || defined(_M_X64)) && (defined(__GNUC__) || defined(__clang__))

#include <immintrin.h>

#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif

namespace selvedge::detail::wide {
namespace {

struct Query {
  __m256 lo[3], hi[3];
};

inline Query spread(const BoxBlock& block, int lane) {
  Query q;
  for (int k = 0; k < 3; ++k) {
    q.lo[k] = _mm256_broadcast_ss(block.lo[k] + lane);
    q.hi[k] = _mm256_broadcast_ss(block.hi[k] + lane);
  }
  return q;
}

inline Query spread(const FloatBox& box) {
  Query q;
  for (int k = 0; k < 3; ++k) {
    q.lo[k] = _mm256_broadcast_ss(&box.lo[k]);
    q.hi[k] = _mm256_broadcast_ss(&box.hi[k]);
  }
  return q;
}

inline unsigned overlap_mask(const BoxBlock& block, const Query& q) {
  __m256 all = _mm256_cmp_ps(_mm256_load_ps(block.lo[0]), q.hi[0], _CMP_LE_OQ);
  all = _mm256_and_ps(all, _mm256_cmp_ps(q.lo[0], _mm256_load_ps(block.hi[0]), _CMP_LE_OQ));
  for (int k = 1; k < 3; ++k) {
    all = _mm256_and_ps(all, _mm256_cmp_ps(_mm256_load_ps(block.lo[k]), q.hi[k], _CMP_LE_OQ));
    all = _mm256_and_ps(all, _mm256_cmp_ps(q.lo[k], _mm256_load_ps(block.hi[k]), _CMP_LE_OQ));
  }
  return static_cast<unsigned>(_mm256_movemask_ps(all));
}

inline unsigned strict_mask(const BoxBlock& block, const Query& q) {
  __m256 all = _mm256_cmp_ps(_mm256_load_ps(block.lo[0]), q.hi[0], _CMP_LT_OQ);
  all = _mm256_and_ps(all, _mm256_cmp_ps(q.lo[0], _mm256_load_ps(block.hi[0]), _CMP_LT_OQ));
  for (int k = 1; k < 3; ++k) {
    all = _mm256_and_ps(all, _mm256_cmp_ps(_mm256_load_ps(block.lo[k]), q.hi[k], _CMP_LT_OQ));
    all = _mm256_and_ps(all, _mm256_cmp_ps(q.lo[k], _mm256_load_ps(block.hi[k]), _CMP_LT_OQ));
  }
  return static_cast<unsigned>(_mm256_movemask_ps(all));
}

inline unsigned equal_mask(const std::int32_t* ids, std::int32_t id) {
  const __m256i lanes = _mm256_load_si256(reinterpret_cast<const __m256i*>(ids));
  const __m256i equal = _mm256_cmpeq_epi32(lanes, _mm256_set1_epi32(id));
  return static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(equal)));
}

#include <selvedge/broadphase/detail/traverse_kernel.inc>

}  // namespace
}  // namespace selvedge::detail::wide

#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

namespace selvedge::detail {

TraversalKernel traversal_kernel_wide() {
  if (!__builtin_cpu_supports("avx2")) return {nullptr, nullptr};
  return {wide::expand, wide::traverse};
}

}  // namespace selvedge::detail

#else

namespace selvedge::detail {

TraversalKernel traversal_kernel_wide() { return {nullptr, nullptr}; }

}  // namespace selvedge::detail

#endif
