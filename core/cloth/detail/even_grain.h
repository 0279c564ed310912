// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>

namespace selvedge::detail {

/// The grain that divides n elements into a power of two of equal ranges, each of at least `least`
/// elements (one range, if there are fewer). Two, four or more threads then end together; a fixed
/// grain leaves 2,500 elements as 2,048 and 452. Depends on nothing else, so that sums over the
/// ranges have the same bits for any number of threads.
inline std::size_t even_grain(std::size_t n, std::size_t least) {
  const std::size_t ranges = std::bit_floor(std::max<std::size_t>(n / least, 1));
  return std::max<std::size_t>((n + ranges - 1) / ranges, 1);
}

}  // namespace selvedge::detail
