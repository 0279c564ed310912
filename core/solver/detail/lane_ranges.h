// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/detail/even_grain.h>
#include <selvedge/core/cloth/detail/lane_matrix.h>

#include <cstddef>

namespace selvedge::detail {

/// Least number of groups of rows per task.
inline constexpr std::size_t kGroupsTogether = 64;

/// Calls body(first, last) on ranges of the groups of rows.
template <class Body>
void by_groups(const LaneVector& x, const Body& body) {
  parallel_for(x.groups(), even_grain(x.groups(), kGroupsTogether), body);
}

/// Sum of body(first, last) over ranges of the groups of rows.
template <class Body>
double sum_by_groups(const LaneVector& x, const Body& body) {
  return parallel_sum(x.groups(), even_grain(x.groups(), kGroupsTogether), body);
}

}  // namespace selvedge::detail
