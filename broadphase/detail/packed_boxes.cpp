// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/packed_boxes.h>
#include <selvedge/core/base/internal/vector_target.h>

#ifdef SELVEDGE_VECTOR_TARGETS
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace selvedge::detail {
namespace {

#ifdef SELVEDGE_VECTOR_TARGETS

constexpr unsigned kUsedLanes = 0x77;  // without 3 and 7

SELVEDGE_TARGET_BEGIN("avx2")
std::uint32_t* scan_avx2(const PackedBox* boxes, std::uint32_t n, const PackedQuery& query,
                         std::uint32_t* out) {
  const __m256 q = _mm256_load_ps(reinterpret_cast<const float*>(&query));
  for (std::uint32_t i = 0; i < n; ++i) {
    const __m256 box = _mm256_load_ps(reinterpret_cast<const float*>(boxes + i));
    const auto hit = static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(box, q, _CMP_LE_OQ)));
    if ((hit & kUsedLanes) != kUsedLanes) continue;
    const auto strict =
        static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(box, q, _CMP_LT_OQ)));
    *out++ = 2 * i + ((strict & kUsedLanes) == kUsedLanes);
  }
  return out;
}
SELVEDGE_TARGET_END

#endif

#ifdef __SSE2__

std::uint32_t* scan_narrow(const PackedBox* boxes, std::uint32_t n, const PackedQuery& query,
                           std::uint32_t* out) {
  constexpr int used = 7;
  const __m128 hi = _mm_load_ps(query.hi), minus_lo = _mm_load_ps(query.minus_lo);
  for (std::uint32_t i = 0; i < n; ++i) {
    const __m128 box_lo = _mm_load_ps(boxes[i].lo), box_minus_hi = _mm_load_ps(boxes[i].minus_hi);
    const __m128 hit = _mm_and_ps(_mm_cmple_ps(box_lo, hi), _mm_cmple_ps(box_minus_hi, minus_lo));
    if ((_mm_movemask_ps(hit) & used) != used) continue;
    const __m128 strict =
        _mm_and_ps(_mm_cmplt_ps(box_lo, hi), _mm_cmplt_ps(box_minus_hi, minus_lo));
    *out++ = 2 * i + ((_mm_movemask_ps(strict) & used) == used);
  }
  return out;
}

#else

std::uint32_t* scan_narrow(const PackedBox* boxes, std::uint32_t n, const PackedQuery& query,
                           std::uint32_t* out) {
  for (std::uint32_t i = 0; i < n; ++i) {
    bool hit = true, strict = true;
    for (int k = 0; k < 3; ++k) {
      hit &= boxes[i].lo[k] <= query.hi[k] && boxes[i].minus_hi[k] <= query.minus_lo[k];
      strict &= boxes[i].lo[k] < query.hi[k] && boxes[i].minus_hi[k] < query.minus_lo[k];
    }
    if (hit) *out++ = 2 * i + strict;
  }
  return out;
}

#endif

}  // namespace

ScanBoxes scan_boxes() {
#ifdef SELVEDGE_VECTOR_TARGETS
  if (__builtin_cpu_supports("avx2")) return scan_avx2;
#endif
  return scan_narrow;
}

Vec3 middle_of(std::span<const std::vector<DoubleBox>* const> lists) {
  constexpr std::size_t most = 255;  // of each list: up to a tenth of the boxes does not move the
                                     // median
  Vec3 middle = Vec3::Zero();
  std::vector<double> sample;
  for (int k = 0; k < 3; ++k) {
    sample.clear();
    for (const std::vector<DoubleBox>* list : lists) {
      const std::size_t step = list->size() / most + 1;
      for (std::size_t i = 0; i < list->size(); i += step) sample.push_back((*list)[i].lo[k]);
    }
    if (sample.empty()) return middle;
    const auto place = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() / 2);
    std::nth_element(sample.begin(), place, sample.end());
    middle[k] = *place;
  }
  return middle;
}

}  // namespace selvedge::detail
