// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/box_pairs.h>
#include <selvedge/broadphase/detail/packed_boxes.h>
#include <selvedge/core/base/parallel.h>

#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

namespace selvedge::detail {

/// A box that is compared with others.
struct ScannedBox {
  PackedQuery packed;
  const DoubleBox& box;
};

inline ScannedBox scanned(const PackedBox& box, const std::vector<DoubleBox>& boxes) {
  return {query_of(box), boxes[box.id]};
}

/// Compares boxes in float, and in double where float does not decide. Each part of an engine's
/// work has its own memory for hits.
class BoxScan {
 public:
  /// Calls near(other, certain) for each of `others` that the query meets in float; `certain`: in
  /// double too.
  template <class Near>
  void each_near(const PackedQuery& query, std::span<const PackedBox> others, std::size_t part,
                 Near near) {
    std::vector<std::uint32_t>& hits = hits_[part];
    if (hits.size() < others.size()) hits.resize(2 * others.size());
    const std::uint32_t* end =
        scan_(others.data(), static_cast<std::uint32_t>(others.size()), query, hits.data());
    for (const std::uint32_t* hit = hits.data(); hit != end; ++hit)
      near(others[*hit / 2], *hit % 2 != 0);
  }

  /// Calls found(other) for each of `others` that overlaps the query; `boxes` are their originals.
  template <class Found>
  void each_overlap(const ScannedBox& query, std::span<const PackedBox> others,
                    const std::vector<DoubleBox>& boxes, std::size_t part, Found found) {
    each_near(query.packed, others, part, [&](const PackedBox& other, bool certain) {
      if (certain || overlap(query.box, boxes[other.id])) found(other);
    });
  }

  std::size_t bytes() const {
    std::size_t sum = 0;
    for (const std::vector<std::uint32_t>& hits : hits_)
      sum += hits.capacity() * sizeof(std::uint32_t);
    return sum;
  }

 private:
  ScanBoxes scan_ = scan_boxes();
  std::vector<std::vector<std::uint32_t>> hits_{kBoxPairParts};
};

/// Sorts boxes into slots. each(visit) calls visit(slot, box, tag) for every entry; a box may have
/// several. `count` does the same, in any order. The entries of slot s become those from begin[s]
/// up to, but excluding, begin[s + 1], in the order of `each`. Throws std::length_error if there
/// are more than 2^32.
template <class Count, class Each>
void sort_into_slots(std::size_t slots, Count count, Each each, std::vector<std::uint32_t>& begin,
                     std::vector<PackedBox>& entries) {
  begin.assign(slots + 1, 0);
  count([&](std::size_t slot, const PackedBox&, std::uint32_t) { ++begin[slot]; });
  std::size_t sum = 0;
  for (std::uint32_t& place : begin) {
    sum += std::exchange(place, static_cast<std::uint32_t>(sum));
    if (sum > std::numeric_limits<std::uint32_t>::max())
      throw std::length_error("broad phase: more than 2^32 boxes in cells; use larger cells");
  }
  entries.resize(sum);
  each([&](std::size_t slot, const PackedBox& box, std::uint32_t tag) {
    PackedBox& entry = entries[begin[slot]++];
    entry = box;
    entry.tag = tag;
  });
  for (std::size_t s = slots; s > 0; --s) begin[s] = begin[s - 1];
  begin[0] = 0;
}

/// The structure of an engine that cuts space into cells and lists every box in all cells that it
/// reaches into. Boxes that reach into too many are wide: in no cell, but compared with all others.
struct ListedBoxes {
  const std::vector<DoubleBox>* boxes = nullptr;
  std::vector<PackedBox> all;        ///< by index; the tag marks wide boxes
  std::vector<PackedBox> wide;       ///< boxes that are in no cell
  std::vector<PackedBox> entries;    ///< by cell
  std::vector<std::uint32_t> begin;  ///< of each cell in `entries`, and the end

  std::size_t bytes() const {
    return (all.capacity() + wide.capacity() + entries.capacity()) * sizeof(PackedBox) +
           begin.capacity() * sizeof(std::uint32_t);
  }
  /// Packs the boxes and marks those for which is_wide(packed) is true.
  template <class IsWide>
  void pack(const std::vector<DoubleBox>& from, const FloatMap& map, IsWide is_wide) {
    boxes = &from;
    all.resize(from.size());
    parallel_for(from.size(), kBoxGrain, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        all[i] = map.pack(from[i], static_cast<std::int32_t>(i));
        all[i].tag = is_wide(all[i]);
      }
    });
    wide.clear();
    for (const PackedBox& box : all)
      if (box.tag) wide.push_back(box);
  }
};

/// The wide boxes of `a` with all of `b`.
template <class Add>
void compare_wide(const ListedBoxes& a, const ListedBoxes& b, BoxScan& scan, Add add) {
  const std::size_t grain = part_grain(b.all.size());
  if (a.wide.empty()) return;
  parallel_for(b.all.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (const PackedBox& box : a.wide)
      scan.each_overlap(scanned(box, *a.boxes), {b.all.data() + begin, end - begin}, *b.boxes,
                        begin / grain,
                        [&](const PackedBox& other) { add(begin / grain, box.id, other.id); });
  });
}

/// The pairs of two lists that have a wide box.
inline void find_wide_pairs(const ListedBoxes& a, const ListedBoxes& b, BoxScan& scan,
                            PairParts& out) {
  compare_wide(a, b, scan,
               [&](std::size_t part, std::int32_t i, std::int32_t j) { out.add(part, i, j); });
  compare_wide(b, a, scan, [&](std::size_t part, std::int32_t j, std::int32_t i) {
    if (!a.all[i].tag) out.add(part, i, j);  // The wide boxes of `a` have met all of `b`.
  });
}

/// The pairs of a list with itself that have a wide box.
inline void find_wide_self_pairs(const ListedBoxes& a, BoxScan& scan, PairParts& out) {
  compare_wide(a, a, scan, [&](std::size_t part, std::int32_t i, std::int32_t j) {
    if (i != j && (!a.all[j].tag || i < j)) out.add(part, i, j);
  });
}

}  // namespace selvedge::detail
