// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>

#include <cstdint>

namespace selvedge::detail {

/// Rows of second indices, each free of duplicates: row r is second[begin[r]] up to, without,
/// second[begin[r + 1]], and belongs to the first index `base` + r. Behind the last row there must
/// be kRowSlack numbers that may be read: a row is read in whole vectors, of at most kLongRow
/// numbers together.
struct PairRows {
  const std::uint32_t* begin;
  std::size_t rows;
  std::uint32_t* second;
  std::int32_t base;
};
inline constexpr std::size_t kRowSlack = 64;

/// Rows of up to so many are sorted by the rank of each number, in vectors and without branches:
/// quadratic, but quicker than anything else while a row is a few vectors long. Others are the
/// caller's, who sorts them first.
inline constexpr std::uint32_t kLongRow = 64;

/// Writes the pairs of all rows in order to `out`. Rows longer than kLongRow must be sorted.
template <class Pair>
using SortRows = void (*)(const PairRows& rows, Pair* out);

/// By plain loops.
template <class Pair>
SortRows<Pair> sort_rows_narrow();
/// By AVX2; null where the compiler or the processor has none.
template <class Pair>
SortRows<Pair> sort_rows_wide();

}  // namespace selvedge::detail
