// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/coloring.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Elements that are worked on side by side, whatever the width of the processor's vectors: the
/// order of all sums depends on this number, and so the bits do not depend on the width.
inline constexpr std::size_t group_lanes = 8;

/// Up to `group_lanes` elements of one chunk. In a run, corner k of lane l is particle first_k + l:
/// their vectors lie side by side in memory and are loaded without gathering.
struct LaneGroup {
  std::uint32_t element;    ///< its first element
  std::uint32_t particles;  ///< where its particles stand in LaneGroups::particles
  std::int16_t count;       ///< lanes in use; what fills the rest is a copy of the last
  bool run;                 ///< `arity` first particles, else `group_lanes` of each corner
};

/// Groups of coloured elements, chunk after chunk.
struct LaneGroups {
  std::vector<LaneGroup> groups;
  std::vector<std::int32_t> particles;
};

/// The groups of the elements [begin, end), which begin where a chunk does and end where one does.
/// All chunks but one are whole, so that it alone has a group that is not full.
inline std::size_t group_of(std::size_t element) {
  return (element + group_lanes - 1) / group_lanes;
}

/// Sorts the elements of every chunk of `coloring` so that as many groups as possible are runs.
/// `particle_of`: the corners of the elements, `arity` each, in their first order.
LaneGroups make_lane_groups(std::span<const std::int32_t> particle_of, std::size_t arity,
                            Coloring& coloring);

/// Numbers of the elements lane by lane: of group g number j at [(g·numbers + j)·group_lanes + l],
/// numbers_of(element) an array of them, for elements already in the order of the groups.
template <std::size_t numbers, class Elements, class NumbersOf>
std::vector<double> lane_numbers(const LaneGroups& lanes, const Elements& elements,
                                 const NumbersOf& numbers_of) {
  std::vector<double> all;
  all.reserve(lanes.groups.size() * numbers * group_lanes);
  for (const LaneGroup& group : lanes.groups) {
    std::array<std::array<double, numbers>, group_lanes> rows;
    const auto count = static_cast<std::size_t>(group.count);
    for (std::size_t l = 0; l < group_lanes; ++l)
      rows[l] = numbers_of(elements[group.element + (l < count ? l : count - 1)]);
    for (std::size_t j = 0; j < numbers; ++j)
      for (std::size_t l = 0; l < group_lanes; ++l) all.push_back(rows[l][j]);
  }
  return all;
}

}  // namespace selvedge::detail
