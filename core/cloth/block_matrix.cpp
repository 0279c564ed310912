// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/detail/even_grain.h>
#include <selvedge/core/cloth/detail/lane_matrix.h>
#include <selvedge/core/cloth/force.h>

#include <algorithm>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

constexpr std::size_t kRows = 512, kValues = 16384;  // least per task

}  // namespace

BlockMatrix::BlockMatrix(std::size_t n, std::vector<Edge> links) : row_begin_(n + 1, 0) {
  const auto count = static_cast<std::int32_t>(n);
  for (Edge& link : links) {
    if (link[0] < 0 || link[1] < 0 || link[0] >= count || link[1] >= count || link[0] == link[1])
      throw std::invalid_argument("block matrix: link " + std::to_string(link[0]) + " to " +
                                  std::to_string(link[1]) + " among " + std::to_string(n) +
                                  " rows");
    if (link[0] > link[1]) std::swap(link[0], link[1]);
  }
  // The upper neighbours of each row: the links by their lower end, then sorted in each row.
  std::vector<std::size_t> first(n + 1, 0);
  for (const Edge& link : links) ++first[link[0] + 1];
  for (std::size_t i = 0; i < n; ++i) first[i + 1] += first[i];
  std::vector<std::int32_t> upper(links.size()), upper_count(n, 0);
  for (const Edge& link : links) upper[first[link[0]] + upper_count[link[0]]++] = link[1];
  parallel_for(n, detail::even_grain(n, kRows), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto of_row = upper.begin() + static_cast<std::ptrdiff_t>(first[i]);
      std::sort(of_row, of_row + upper_count[i]);
      upper_count[i] =
          static_cast<std::int32_t>(std::unique(of_row, of_row + upper_count[i]) - of_row);
    }
  });
  const auto neighbours = [&](std::size_t i) {
    return std::span(upper).subspan(first[i], static_cast<std::size_t>(upper_count[i]));
  };

  for (std::size_t i = 0; i < n; ++i) {
    row_begin_[i + 1] += upper_count[i] + 1;
    for (const std::int32_t j : neighbours(i)) ++row_begin_[j + 1];
  }
  for (std::size_t i = 0; i < n; ++i) row_begin_[i + 1] += row_begin_[i];
  column_.resize(row_begin_[n]);
  diagonal_.resize(n);
  std::vector<std::int32_t> next(row_begin_.begin(), row_begin_.end() - 1);
  // A row gets its lower neighbours in order, then itself, then the upper ones.
  for (std::size_t i = 0; i < n; ++i) {
    diagonal_[i] = next[i];
    column_[next[i]++] = static_cast<std::int32_t>(i);
    for (const std::int32_t j : neighbours(i)) {
      column_[next[i]++] = j;
      column_[next[j]++] = static_cast<std::int32_t>(i);
    }
  }
  values_.assign(column_.size(), Mat3::Zero());
}

void BlockMatrix::set_zero() {
  parallel_for(values_.size(), detail::even_grain(values_.size(), kValues),
               [&](std::size_t begin, std::size_t end) {
                 std::fill(values_.begin() + begin, values_.begin() + end, Mat3::Zero());
               });
}

void BlockMatrix::set_zero(std::size_t first, std::size_t last) {
  std::fill(values_.begin() + row_begin_[first], values_.begin() + row_begin_[last], Mat3::Zero());
}

std::int32_t BlockMatrix::slot(std::int32_t i, std::int32_t j) const {
  if (i >= 0 && static_cast<std::size_t>(i) < size()) {
    const auto begin = column_.begin() + row_begin_[i], end = column_.begin() + row_begin_[i + 1];
    const auto found = std::lower_bound(begin, end, j);
    if (found != end && *found == j) return static_cast<std::int32_t>(found - column_.begin());
  }
  throw std::out_of_range("block matrix: no block (" + std::to_string(i) + ", " +
                          std::to_string(j) + ")");
}

void BlockMatrix::multiply(std::span<const Vec3> x, std::span<Vec3> y) const {
  SELVEDGE_ASSERT(x.size() == size() && y.size() == size());
  if (size() == 0) return;
  parallel_for(size(), detail::even_grain(size(), kRows), [&](std::size_t begin, std::size_t end) {
    detail::lane_matrix_kernel().multiply_blocks(
        row_begin_.data(), column_.data(), values_[0].data(), x[0].data(), y[0].data(), begin, end);
  });
}

}  // namespace selvedge
