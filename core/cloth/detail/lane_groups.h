// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/detail/coloring.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Number of elements that are processed side by side, independent of the processor's vector width.
/// The order of all sums depends on this number, so results do not depend on the width.
inline constexpr std::size_t kGroupLanes = 8;

/// Up to `kGroupLanes` elements of one chunk. In a run, corner k of lane l is particle first_k + l,
/// so the vectors are adjacent in memory and are loaded without a gather.
struct LaneGroup {
  std::uint32_t element;    ///< index of its first element
  std::uint32_t particles;  ///< start of its particles in LaneGroups::particles
  std::int16_t count;       ///< lanes in use; the other lanes repeat the last element
  bool run;                 ///< stores `arity` first particles, else `kGroupLanes` for each corner
};

/// Groups of coloured elements, chunk after chunk.
struct LaneGroups {
  std::vector<LaneGroup> groups;
  std::vector<std::int32_t> particles;
};

/// Number of groups before `element`, which must be the start or the end of a chunk. All chunks but
/// one are full, so only that one has a group that is not full.
inline std::size_t group_of(std::size_t element) {
  return (element + kGroupLanes - 1) / kGroupLanes;
}

/// Sorts the elements within each chunk of `coloring` so that as many groups as possible are runs.
/// `particle_of`: the corners of the elements, `arity` each, in the original order.
LaneGroups make_lane_groups(std::span<const std::int32_t> particle_of, std::size_t arity,
                            Coloring& coloring);

/// Per-element numbers stored lane by lane: number j of group g is at [(g·numbers + j)·kGroupLanes
/// + l]. numbers_of(element) returns an array. The elements must already be in the order of the
/// groups.
template <std::size_t numbers, class Elements, class NumbersOf>
std::vector<double> lane_numbers(const LaneGroups& lanes, const Elements& elements,
                                 const NumbersOf& numbers_of) {
  std::vector<double> all;
  all.reserve(lanes.groups.size() * numbers * kGroupLanes);
  for (const LaneGroup& group : lanes.groups) {
    std::array<std::array<double, numbers>, kGroupLanes> rows;
    const auto count = static_cast<std::size_t>(group.count);
    for (std::size_t l = 0; l < kGroupLanes; ++l)
      rows[l] = numbers_of(elements[group.element + (l < count ? l : count - 1)]);
    for (std::size_t j = 0; j < numbers; ++j)
      for (std::size_t l = 0; l < kGroupLanes; ++l) all.push_back(rows[l][j]);
  }
  return all;
}

}  // namespace selvedge::detail
