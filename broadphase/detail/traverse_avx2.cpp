// SPDX-License-Identifier: MIT
// The traversal with vectors of eight floats.
#include <selvedge/broadphase/detail/traverse.h>
#include <selvedge/core/base/internal/vector_target.h>

#include <array>
#include <bit>
#include <cmath>

#ifdef SELVEDGE_VECTOR_TARGETS

#include <immintrin.h>

SELVEDGE_TARGET_BEGIN("avx2,bmi,popcnt")
namespace selvedge::detail::wide {
namespace {

using Vector = __m256;
inline Vector broadcast(float x) { return _mm256_set1_ps(x); }
#include <selvedge/broadphase/detail/traverse_query.inc>

template <int axes>
inline unsigned overlap_mask(const DopBlock<axes>& block, const Query<axes>& q) {
  __m256 all = _mm256_cmp_ps(_mm256_load_ps(block.lo[0]), q.hi[0], _CMP_LE_OQ);
  all = _mm256_and_ps(all, _mm256_cmp_ps(q.lo[0], _mm256_load_ps(block.hi[0]), _CMP_LE_OQ));
  for (int k = 1; k < axes; ++k) {
    all = _mm256_and_ps(all, _mm256_cmp_ps(_mm256_load_ps(block.lo[k]), q.hi[k], _CMP_LE_OQ));
    all = _mm256_and_ps(all, _mm256_cmp_ps(q.lo[k], _mm256_load_ps(block.hi[k]), _CMP_LE_OQ));
  }
  return static_cast<unsigned>(_mm256_movemask_ps(all));
}

/// Upper bound of the penetration of each box into the query: negative if they are apart, 0 if they
/// just touch, NaN in unused lanes. The sign of a difference of floats is that of the comparison;
/// an underflow to 0 merely causes a test in double.
template <int axes>
inline Hits test(const DopBlock<axes>& block, const Query<axes>& q) {
  const auto depth = [&](int k) {
    return _mm256_min_ps(_mm256_sub_ps(q.hi[k], _mm256_load_ps(block.lo[k])),
                         _mm256_sub_ps(_mm256_load_ps(block.hi[k]), q.lo[k]));
  };
  __m256 least = _mm256_min_ps(_mm256_min_ps(depth(0), depth(1)), depth(2));
  for (int k = 3; k < axes; ++k) least = _mm256_min_ps(least, depth(k));
  const __m256 zero = _mm256_setzero_ps();
  const auto mask = [](__m256 m) { return static_cast<unsigned>(_mm256_movemask_ps(m)); };
  return {mask(_mm256_cmp_ps(least, zero, _CMP_GE_OQ)),
          mask(_mm256_cmp_ps(least, zero, _CMP_EQ_OQ))};
}

inline unsigned equal_mask(const std::int32_t* ids, std::int32_t id) {
  const __m256i lanes = _mm256_load_si256(reinterpret_cast<const __m256i*>(ids));
  const __m256i equal = _mm256_cmpeq_epi32(lanes, _mm256_set1_epi32(id));
  return static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(equal)));
}

/// For each mask of lanes, the source lanes of the eight positions of two unpacked vectors.
struct PackTable {
  alignas(64) std::uint8_t lane[256][kLanes] = {};

  constexpr PackTable() {
    // Unpacking the low and the high halves puts these positions in order.
    constexpr int place[kLanes] = {0, 1, 4, 5, 2, 3, 6, 7};
    for (unsigned mask = 0; mask < 256; ++mask)
      for (unsigned i = 0, next = 0; i < kLanes; ++i)
        if (mask >> i & 1) lane[mask][place[next++]] = static_cast<std::uint8_t>(i);
  }
};
constexpr PackTable kPack;

/// Writes the keys firsts << 32 | seconds of the lanes in `hits`; up to eight keys may be
/// overwritten with arbitrary values.
inline std::uint64_t* pack(__m256i firsts, __m256i seconds, unsigned hits, std::uint64_t* out) {
  const __m256i lanes =
      _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(kPack.lane[hits])));
  firsts = _mm256_permutevar8x32_epi32(firsts, lanes);
  seconds = _mm256_permutevar8x32_epi32(seconds, lanes);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), _mm256_unpacklo_epi32(seconds, firsts));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(out) + 1, _mm256_unpackhi_epi32(seconds, firsts));
  return out + __builtin_popcount(hits);
}

inline std::uint64_t* append(std::int32_t first, const std::int32_t* seconds, unsigned hits,
                             std::uint64_t* out) {
  return pack(_mm256_set1_epi32(first),
              _mm256_load_si256(reinterpret_cast<const __m256i*>(seconds)), hits, out);
}

inline std::uint64_t* append_reversed(std::int32_t second, const std::int32_t* firsts,
                                      unsigned hits, std::uint64_t* out) {
  return pack(_mm256_load_si256(reinterpret_cast<const __m256i*>(firsts)),
              _mm256_set1_epi32(second), hits, out);
}

inline std::uint64_t* append_ordered(std::int32_t one, const std::int32_t* others, unsigned hits,
                                     std::uint64_t* out) {
  const __m256i a = _mm256_set1_epi32(one);
  const __m256i b = _mm256_load_si256(reinterpret_cast<const __m256i*>(others));
  return pack(_mm256_min_epi32(a, b), _mm256_max_epi32(a, b), hits, out);
}

#include <selvedge/broadphase/detail/traverse_kernel.inc>

}  // namespace
}  // namespace selvedge::detail::wide
SELVEDGE_TARGET_END

#endif

namespace selvedge::detail {

template <BoundingVolume V>
TraversalKernel<V> traversal_kernel_wide() {
#ifdef SELVEDGE_VECTOR_TARGETS
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
      __builtin_cpu_supports("popcnt"))
    return {wide::expand<V>, wide::traverse<V>};
#endif
  return {nullptr, nullptr};
}

template TraversalKernel<AabbVolume> traversal_kernel_wide();
template TraversalKernel<KDopVolume<14>> traversal_kernel_wide();
template TraversalKernel<KDopVolume<18>> traversal_kernel_wide();
template TraversalKernel<KDopVolume<26>> traversal_kernel_wide();
template TraversalKernel<ObbVolume> traversal_kernel_wide();

}  // namespace selvedge::detail
