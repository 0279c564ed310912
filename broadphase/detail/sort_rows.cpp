// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/sort_rows.h>
#include <selvedge/core/base/internal/vector_target.h>

#include <algorithm>
#include <array>
#include <utility>

#ifdef SELVEDGE_VECTOR_TARGETS
#include <immintrin.h>
#endif

namespace selvedge::detail {
namespace {

constexpr int kDigitBits = 9;  // 512 counters of four bytes: half of a first-level cache
constexpr std::size_t kDigitValues = std::size_t{1} << kDigitBits;
constexpr std::size_t kVeryLongRow = 512;  // from this length on, sorting by digits is faster

/// Sorts by digits, lowest first. `scratch` has the size of the row.
void sort_by_digits(std::span<std::uint32_t> row, int bits, std::uint32_t* scratch) {
  std::uint32_t *from = row.data(), *to = scratch;
  for (int shift = 0; shift < bits; shift += kDigitBits, std::swap(from, to)) {
    const auto digit = [&](std::uint32_t value) { return value >> shift & (kDigitValues - 1); };
    std::array<std::uint32_t, kDigitValues> next{};
    for (std::size_t i = 0; i < row.size(); ++i) ++next[digit(from[i])];
    std::uint32_t sum = 0;
    for (std::uint32_t& place : next) sum += std::exchange(place, sum);
    for (std::size_t i = 0; i < row.size(); ++i) to[next[digit(from[i])]++] = from[i];
  }
  if (from != row.data()) std::copy(from, from + row.size(), row.data());
}

}  // namespace

void sort_long_row(std::span<std::uint32_t> row, int bits, std::vector<std::uint32_t>& scratch) {
  if (row.size() < kVeryLongRow) {
    std::sort(row.begin(), row.end());
    return;
  }
  scratch.resize(std::max(scratch.size(), row.size()));
  sort_by_digits(row, bits, scratch.data());
}

namespace {

template <class Pair>
void copy_row(std::int32_t first, const std::uint32_t* row, std::uint32_t n, Pair* out) {
  for (std::uint32_t i = 0; i < n; ++i) out[i] = {first, static_cast<std::int32_t>(row[i])};
}

namespace narrow {

template <class Pair>
void rank_row(std::int32_t first, const std::uint32_t* row, std::uint32_t n, Pair* out) {
  for (std::uint32_t i = 0; i < n; ++i) {
    std::uint32_t rank = 0;
    for (std::uint32_t k = 0; k < n; ++k)
      rank += static_cast<std::int32_t>(row[k]) < static_cast<std::int32_t>(row[i]);
    out[rank] = {first, static_cast<std::int32_t>(row[i])};
  }
}

template <class Pair>
void sort_rows(const PairRows& rows, Pair* out) {
  for (std::size_t r = 0; r < rows.rows; ++r) {
    const std::uint32_t begin = rows.begin[r], n = rows.begin[r + 1] - begin;
    const std::int32_t first = rows.base + static_cast<std::int32_t>(r);
    if (n <= kLongRow)
      rank_row(first, rows.second + begin, n, out + begin);
    else
      copy_row(first, rows.second + begin, n, out + begin);
  }
}

}  // namespace narrow
}  // namespace

template <class Pair>
SortRows<Pair> sort_rows_narrow() {
  return narrow::sort_rows<Pair>;
}

template SortRows<PointTrianglePair> sort_rows_narrow();
template SortRows<EdgeEdgePair> sort_rows_narrow();

#ifdef SELVEDGE_VECTOR_TARGETS

SELVEDGE_TARGET_BEGIN("avx2,popcnt")
namespace {
namespace wide {

/// For a row that fits into `vectors` vectors of eight.
template <int vectors, class Pair>
inline void rank_row(std::int32_t first, const std::uint32_t* row, std::uint32_t n, Pair* out) {
  __m256i lanes[vectors];
  const __m256i size = _mm256_set1_epi32(static_cast<int>(n));
  __m256i place = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  for (int v = 0; v < vectors; ++v) {
    // Entries after the row become greater than all others.
    const __m256i behind = _mm256_xor_si256(_mm256_cmpgt_epi32(size, place), _mm256_set1_epi32(-1));
    const __m256i all = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(row) + v);
    lanes[v] = _mm256_or_si256(_mm256_andnot_si256(behind, all), _mm256_srli_epi32(behind, 1));
    place = _mm256_add_epi32(place, _mm256_set1_epi32(8));
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const auto second = static_cast<std::int32_t>(row[i]);
    const __m256i value = _mm256_set1_epi32(second);
    int rank = 0;
    for (int v = 0; v < vectors; ++v)
      rank += __builtin_popcount(static_cast<unsigned>(
          _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpgt_epi32(value, lanes[v])))));
    out[rank] = {first, second};
  }
}

template <class Pair>
void sort_rows(const PairRows& rows, Pair* out) {
  for (std::size_t r = 0; r < rows.rows; ++r) {
    const std::uint32_t begin = rows.begin[r], n = rows.begin[r + 1] - begin;
    const std::int32_t first = rows.base + static_cast<std::int32_t>(r);
    const std::uint32_t* row = rows.second + begin;
    if (n <= 8)
      rank_row<1>(first, row, n, out + begin);
    else if (n <= 16)
      rank_row<2>(first, row, n, out + begin);
    else if (n <= 24)
      rank_row<3>(first, row, n, out + begin);
    else if (n <= 40)
      rank_row<5>(first, row, n, out + begin);
    else if (n <= 64)
      rank_row<8>(first, row, n, out + begin);
    else if (n <= 96)
      rank_row<12>(first, row, n, out + begin);
    else if (n <= kLongRow)
      rank_row<16>(first, row, n, out + begin);
    else
      copy_row(first, row, n, out + begin);
  }
}

}  // namespace wide
}  // namespace
SELVEDGE_TARGET_END

#endif

template <class Pair>
SortRows<Pair> sort_rows_wide() {
#ifdef SELVEDGE_VECTOR_TARGETS
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("popcnt"))
    return wide::sort_rows<Pair>;
#endif
  return nullptr;
}

template SortRows<PointTrianglePair> sort_rows_wide();
template SortRows<EdgeEdgePair> sort_rows_wide();

}  // namespace selvedge::detail
