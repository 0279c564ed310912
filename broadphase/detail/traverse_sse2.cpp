// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/traverse.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace selvedge::detail {
namespace narrow {
namespace {

#ifdef __SSE2__

using Vector = __m128;
inline Vector broadcast(float x) { return _mm_set1_ps(x); }
#include <selvedge/broadphase/detail/traverse_query.inc>

template <int axes, class Less>
inline unsigned compare(const DopBlock<axes>& block, const Query<axes>& q, Less less) {
  unsigned mask = 0;
  for (int half = 0; half < kLanes; half += 4) {
    __m128 all = _mm_castsi128_ps(_mm_set1_epi32(-1));
    for (int k = 0; k < axes; ++k) {
      all = _mm_and_ps(all, less(_mm_load_ps(block.lo[k] + half), q.hi[k]));
      all = _mm_and_ps(all, less(q.lo[k], _mm_load_ps(block.hi[k] + half)));
    }
    mask |= static_cast<unsigned>(_mm_movemask_ps(all)) << half;
  }
  return mask;
}

template <int axes>
inline unsigned overlap_mask(const DopBlock<axes>& block, const Query<axes>& q) {
  return compare(block, q, [](__m128 a, __m128 b) { return _mm_cmple_ps(a, b); });
}
template <int axes>
inline unsigned strict_mask(const DopBlock<axes>& block, const Query<axes>& q) {
  return compare(block, q, [](__m128 a, __m128 b) { return _mm_cmplt_ps(a, b); });
}

inline unsigned equal_mask(const std::int32_t* ids, std::int32_t id) {
  unsigned mask = 0;
  for (int half = 0; half < kLanes; half += 4) {
    const __m128i lanes = _mm_load_si128(reinterpret_cast<const __m128i*>(ids + half));
    const __m128i equal = _mm_cmpeq_epi32(lanes, _mm_set1_epi32(id));
    mask |= static_cast<unsigned>(_mm_movemask_ps(_mm_castsi128_ps(equal))) << half;
  }
  return mask;
}

#else

using Vector = float;
inline Vector broadcast(float x) { return x; }
#include <selvedge/broadphase/detail/traverse_query.inc>

template <int axes>
inline unsigned overlap_mask(const DopBlock<axes>& block, const Query<axes>& q) {
  unsigned mask = 0;
  for (int i = 0; i < kLanes; ++i) {
    bool all = true;
    for (int k = 0; k < axes; ++k) all &= (block.lo[k][i] <= q.hi[k]) & (q.lo[k] <= block.hi[k][i]);
    mask |= static_cast<unsigned>(all) << i;
  }
  return mask;
}
template <int axes>
inline unsigned strict_mask(const DopBlock<axes>& block, const Query<axes>& q) {
  unsigned mask = 0;
  for (int i = 0; i < kLanes; ++i) {
    bool all = true;
    for (int k = 0; k < axes; ++k) all &= (block.lo[k][i] < q.hi[k]) & (q.lo[k] < block.hi[k][i]);
    mask |= static_cast<unsigned>(all) << i;
  }
  return mask;
}

inline unsigned equal_mask(const std::int32_t* ids, std::int32_t id) {
  unsigned mask = 0;
  for (int i = 0; i < kLanes; ++i) mask |= static_cast<unsigned>(ids[i] == id) << i;
  return mask;
}

#endif

template <int axes>
inline Hits test(const DopBlock<axes>& block, const Query<axes>& query) {
  const unsigned closed = overlap_mask(block, query);
  return {closed, closed ? closed & ~strict_mask(block, query) : 0u};
}

inline std::uint64_t* append(std::int32_t first, const std::int32_t* seconds, unsigned hits,
                             std::uint64_t* out) {
  for (; hits; hits &= hits - 1) *out++ = key_of(first, seconds[std::countr_zero(hits)]);
  return out;
}

inline std::uint64_t* append_reversed(std::int32_t second, const std::int32_t* firsts,
                                      unsigned hits, std::uint64_t* out) {
  for (; hits; hits &= hits - 1) *out++ = key_of(firsts[std::countr_zero(hits)], second);
  return out;
}

inline std::uint64_t* append_ordered(std::int32_t one, const std::int32_t* others, unsigned hits,
                                     std::uint64_t* out) {
  for (; hits; hits &= hits - 1) {
    const std::int32_t other = others[std::countr_zero(hits)];
    *out++ = key_of(std::min(one, other), std::max(one, other));
  }
  return out;
}

#include <selvedge/broadphase/detail/traverse_kernel.inc>

}  // namespace
}  // namespace narrow

template <BoundingVolume V>
TraversalKernel<V> traversal_kernel_narrow() {
  return {narrow::expand<V>, narrow::traverse<V>};
}

template TraversalKernel<AabbVolume> traversal_kernel_narrow();
template TraversalKernel<KDopVolume<14>> traversal_kernel_narrow();
template TraversalKernel<KDopVolume<18>> traversal_kernel_narrow();
template TraversalKernel<KDopVolume<26>> traversal_kernel_narrow();
template TraversalKernel<ObbVolume> traversal_kernel_narrow();

template <int axes>
bool point_triangle_overlap(const SurfaceView& a, std::int32_t point, const SurfaceView& b,
                            std::int32_t triangle) {
  return overlap(swept_dop<axes>(path_of(a, point)), swept_dop<axes>(b, b.triangles[triangle]));
}

template <int axes>
bool edge_edge_overlap(const SurfaceView& a, std::int32_t edge_a, const SurfaceView& b,
                       std::int32_t edge_b) {
  return overlap(swept_dop<axes>(a, a.edges[edge_a]), swept_dop<axes>(b, b.edges[edge_b]));
}

#define SELVEDGE_INSTANTIATE(axes)                                                                 \
  template bool point_triangle_overlap<axes>(const SurfaceView&, std::int32_t, const SurfaceView&, \
                                             std::int32_t);                                        \
  template bool edge_edge_overlap<axes>(const SurfaceView&, std::int32_t, const SurfaceView&,      \
                                        std::int32_t)
SELVEDGE_INSTANTIATE(3);
SELVEDGE_INSTANTIATE(7);
SELVEDGE_INSTANTIATE(9);
SELVEDGE_INSTANTIATE(13);

}  // namespace selvedge::detail
