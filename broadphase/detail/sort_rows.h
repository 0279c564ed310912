// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Rows of second indices, each free of duplicates: row r is second[begin[r]] up to, but excluding,
/// second[begin[r + 1]], and belongs to the first index `base` + r. At least kRowSlack readable
/// numbers must follow the last row, because rows are read in whole vectors of at most kLongRow
/// numbers together.
struct PairRows {
  const std::uint32_t* begin;
  std::size_t rows;
  std::uint32_t* second;
  std::int32_t base;
};
inline constexpr std::size_t kRowSlack = 128;

/// Rows up to this length are sorted by the rank of each number, in vectors and without branches:
/// quadratic, but the fastest method while a row is a few vectors long. The caller sorts longer
/// rows first.
inline constexpr std::uint32_t kLongRow = 128;

/// Writes the pairs of all rows in order to `out`. Rows longer than kLongRow must be sorted.
template <class Pair>
using SortRows = void (*)(const PairRows& rows, Pair* out);

/// Version with plain loops.
template <class Pair>
SortRows<Pair> sort_rows_narrow();
/// Version with AVX2; null if the compiler or the processor does not support it.
template <class Pair>
SortRows<Pair> sort_rows_wide();
/// The widest version that the processor supports.
template <class Pair>
SortRows<Pair> best_sort_rows() {
  const SortRows<Pair> wide = sort_rows_wide<Pair>();
  return wide ? wide : sort_rows_narrow<Pair>();
}

/// Sorts a row that is longer than kLongRow; its numbers have at most `bits` bits.
void sort_long_row(std::span<std::uint32_t> row, int bits, std::vector<std::uint32_t>& scratch);

}  // namespace selvedge::detail
