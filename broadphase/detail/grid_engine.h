// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/box_scan.h>
#include <selvedge/core/base/parallel.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace selvedge::detail {

using Cell = std::array<std::int32_t, 3>;

/// Levels of cells: level l holds the boxes whose largest extent is from half to twice the length
/// cell·4^l; the side of its cells is kStretch such lengths, at least one. So no box, however
/// large, spreads over more than three cells along an axis, and each mesh size meets cells of its
/// own size.
inline constexpr int kLevelBits = 2;
/// A level with at most this many boxes is searched without cells.
inline constexpr std::uint32_t kFewBoxes = 32;
/// Maximum number of slots per box, unless the cells fit into fewer.
inline constexpr std::size_t kSlotsPerBox = 4;
/// Cells farther out count as the last one; coordinate tests still distinguish their boxes.
inline constexpr float kMostCells = 1 << 30;

/// Range of levels. A box smaller than 2^-20 cells (usually a point) goes to level 0: finer cells
/// would not separate more boxes.
inline constexpr int kLowestLevel = -10, kHighestLevel = 1023;

/// Level of a box of this extent if the cells of level 0 have the side `cell`.
int level_of(float extent, double cell);

/// The typical largest extent, under the map, of the boxes of edges (of triangles or points if
/// there are none): the median of a sample, on which a few spikes have no influence. 1 if all are
/// points.
double typical_extent(const SurfaceBoxes& a, const SurfaceBoxes* b, const FloatMap& map);

/// Chooses floats for the boxes of both surfaces, and cells of `relative_cell` typical extents:
/// relative to an origin amid the boxes, or by quantiles if many boxes would be smaller than
/// `finest` cells or below the resolution of floats. Returns true if `map` and `cell` are unchanged
/// because they still serve: cells as fine, within a fourth, and floats not much coarser.
bool place_cells(const SurfaceBoxes& a, const SurfaceBoxes* b, double relative_cell, double finest,
                 FloatMap& map, double& cell);

/// Returns `cell` if it is finite and greater than 0; otherwise throws std::invalid_argument.
double checked_cell(double cell, const std::string& detector);

/// The option of CellGridConfig.
MethodOption cell_option();

/// Boxes of one level: a range of the packed boxes, and the cells into which they are sorted, each
/// by its lower corner only. A search widens the query by `reach` instead, so that no box is found
/// twice.
template <class Slots>
struct GridLevel {
  int level = 0;
  std::uint32_t first = 0, count = 0;
  float inverse_cell = 1.0f;
  float reach = 0.0f;  ///< largest extent
  bool sorted = false;
  Cell min{}, max{};  ///< range of cells of the lower corners
  Slots slots;
  std::vector<std::uint32_t> begin;  ///< start of each slot in the packed boxes, and the end

  std::int32_t cell(float x) const {
    const float scaled = std::clamp(x * inverse_cell, -kMostCells, kMostCells);
    const auto whole = static_cast<std::int32_t>(scaled);
    return whole - (scaled < static_cast<float>(whole));
  }
  Cell cell(const PackedBox& box) const {
    return {cell(box.lo[0]), cell(box.lo[1]), cell(box.lo[2])};
  }
};

/// Finds pairs of boxes by levels of grids. `Slots` maps cells to slots of a table:
///   kStretch: see kLevelBits; kTagged: whether tags are used;
///   fit(min, max, slots): sets the range of cells; returns the number of slots;
///   slot(cell): its slot;
///   each_run(min, max, visit): calls visit(first, last, tag) for runs of slots that contain the
///     cells of a row, min to max along x: no slot twice, and the slot of max at the end of the
///     last run;
///   tag(cell): distinguishes boxes of this cell from those of other nearby cells in the same slot.
template <class Slots>
class GridEngine {
 public:
  using Level = GridLevel<Slots>;

  struct Structure {
    const std::vector<DoubleBox>* boxes = nullptr;
    std::vector<PackedBox> packed;  ///< by level, the smallest first
    std::vector<Level> levels;      ///< the levels that contain boxes

    std::size_t bytes() const {
      std::size_t sum = packed.capacity() * sizeof(PackedBox);
      for (const Level& level : levels) sum += level.begin.capacity() * sizeof(std::uint32_t);
      return sum;
    }
  };

  /// `cell`: side of the cells of level 0 in typical extents.
  explicit GridEngine(double cell) : relative_cell_(cell) {}

  bool prepare(const SurfaceBoxes& a, const SurfaceBoxes* b) {
    return place_cells(a, b, relative_cell_, kFinest, map_, cell_);
  }

  void build(const std::vector<DoubleBox>& boxes, Structure& out) {
    out.boxes = &boxes;
    out.packed.resize(boxes.size());
    levels_of_.resize(boxes.size());
    if (packed_.size() < boxes.size()) packed_.resize(boxes.size());
    if (slot_of_.size() < boxes.size()) slot_of_.resize(boxes.size());
    parallel_for(boxes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        packed_[i] = map_.pack(boxes[i], static_cast<std::int32_t>(i));
        levels_of_[i] = static_cast<std::int16_t>(level_of(extent(packed_[i]), cell_));
      }
    });
    make_levels(out);
  }

  void find_pairs(Structure& a, Structure& b, PairParts& out) {
    for (Level& level : b.levels)
      look_up_all(a, 0, end_of_levels(a, level.level), b, level,
                  [&](std::size_t part, std::int32_t i, std::int32_t j) { out.add(part, i, j); });
    for (Level& level : a.levels)
      look_up_all(b, 0, end_of_levels(b, level.level - 1), a, level,
                  [&](std::size_t part, std::int32_t j, std::int32_t i) { out.add(part, i, j); });
  }

  void find_self_pairs(Structure& a, PairParts& out) {
    const auto add = [&](std::size_t part, std::int32_t i, std::int32_t j) { out.add(part, i, j); };
    for (Level& level : a.levels) {
      look_up_all(a, 0, level.first, a, level, add);
      look_up_within(a, level, add);
    }
  }

  std::size_t bytes() const {
    return packed_.capacity() * sizeof(PackedBox) + slot_of_.capacity() * sizeof(std::uint32_t) +
           levels_of_.capacity() * sizeof(std::int16_t) + scan_.bytes();
  }

 private:
  static constexpr std::size_t kGrain = 4096;
  static constexpr double kFinest = 0x1p-16;  // cells: well above the size at which kLowestLevel
                                              // ends

  /// Two opposite cells.
  struct Window {
    Cell min, max;
  };

  static float extent(const PackedBox& box) {
    float most = 0.0f;
    for (int k = 0; k < 3; ++k) most = std::max(most, -box.minus_hi[k] - box.lo[k]);
    return most;
  }

  /// Sorts packed_ by level into out.packed.
  void make_levels(Structure& out) {
    counts_.assign(kHighestLevel - kLowestLevel + 1, 0);
    const auto n = static_cast<std::uint32_t>(out.packed.size());
    int lowest = kHighestLevel, highest = kLowestLevel;
    for (std::uint32_t i = 0; i < n; ++i) {
      ++counts_[levels_of_[i] - kLowestLevel];
      lowest = std::min<int>(lowest, levels_of_[i]);
      highest = std::max<int>(highest, levels_of_[i]);
    }
    std::size_t used = 0;
    std::uint32_t first = 0, waiting = 0;
    for (int level = lowest; level <= highest; ++level) {
      std::uint32_t& count = counts_[level - kLowestLevel];
      waiting += std::exchange(count, first + waiting);
      // A few boxes join those of the next level that contains any.
      if (waiting == 0 || (waiting < kFewBoxes && level < highest)) continue;
      if (out.levels.size() == used) out.levels.emplace_back();
      Level& made = out.levels[used++];
      made.level = level;
      made.first = first;
      made.count = waiting;
      made.sorted = false;
      made.inverse_cell = static_cast<float>(
          1.0 / std::max<double>(Slots::kStretch * std::ldexp(cell_, kLevelBits * level),
                                 std::numeric_limits<float>::min()));
      first += waiting;
      waiting = 0;
    }
    out.levels.resize(used);
    for (std::uint32_t i = 0; i < n; ++i)
      out.packed[counts_[levels_of_[i] - kLowestLevel]++] = packed_[i];
  }

  /// Number of boxes of this level or lower ones.
  static std::uint32_t end_of_levels(const Structure& s, int level) {
    std::uint32_t end = 0;
    for (const Level& l : s.levels)
      if (l.level <= level) end = l.first + l.count;
    return end;
  }

  /// Sorts the boxes of a level by slots, unless this is done already or they are few.
  void sort(Structure& s, Level& level) {
    if (level.sorted || level.count <= kFewBoxes) return;
    PackedBox* boxes = s.packed.data() + level.first;
    level.reach = 0.0f;
    level.min = level.max = level.cell(boxes[0]);
    for (std::uint32_t i = 0; i < level.count; ++i) {
      const Cell cell = level.cell(boxes[i]);
      for (int k = 0; k < 3; ++k) {
        level.min[k] = std::min(level.min[k], cell[k]);
        level.max[k] = std::max(level.max[k], cell[k]);
      }
      level.reach = std::max(level.reach, extent(boxes[i]));
    }
    level.reach = std::nextafter(level.reach, std::numeric_limits<float>::infinity());
    const std::size_t slots =
        level.slots.fit(level.min, level.max, kSlotsPerBox * std::size_t{level.count});
    level.begin.assign(slots + 1, 0);
    for (std::uint32_t i = 0; i < level.count; ++i) {
      const Cell cell = level.cell(boxes[i]);
      boxes[i].tag = level.slots.tag(cell);
      slot_of_[i] = level.slots.slot(cell);
      ++level.begin[slot_of_[i]];
    }
    std::uint32_t sum = 0;
    for (std::uint32_t& place : level.begin) sum += std::exchange(place, sum);
    std::copy(boxes, boxes + level.count, packed_.begin());
    for (std::uint32_t i = 0; i < level.count; ++i) boxes[level.begin[slot_of_[i]]++] = packed_[i];
    for (std::size_t i = slots; i > 0; --i) level.begin[i] = level.begin[i - 1];
    level.begin[0] = 0;
    level.sorted = true;
  }

  /// Runs look_up(i, part) for all i of [begin, end), in parts.
  template <class LookUp>
  void for_parts(std::uint32_t begin, std::uint32_t end, LookUp look_up) {
    const std::size_t grain = part_grain(end - begin);
    parallel_for(end - begin, grain, [&](std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i)
        look_up(begin + static_cast<std::uint32_t>(i), from / grain);
    });
  }

  /// Boxes [begin, end) of `queries` against a level of `s`.
  template <class Add>
  void look_up_all(const Structure& queries, std::uint32_t begin, std::uint32_t end, Structure& s,
                   Level& level, Add add) {
    if (begin >= end) return;
    sort(s, level);
    for_parts(begin, end, [&](std::uint32_t i, std::size_t part) {
      const PackedBox& box = queries.packed[i];
      const ScannedBox query = scanned(box, *queries.boxes);
      const auto scan = [&](const PackedBox* others, std::uint32_t n, std::uint32_t tag) {
        scan_.each_overlap(query, {others, n}, *s.boxes, part, [&](const PackedBox& other) {
          if (!is_tagged(level) || other.tag == tag) add(part, box.id, other.id);
        });
      };
      const PackedBox* boxes = s.packed.data() + level.first;
      if (!level.sorted) return scan(boxes, level.count, 0);
      const Window window = window_of(level, box);
      Cell row = window.min, row_end = window.max;
      for (row[2] = window.min[2]; row[2] <= window.max[2]; ++row[2])
        for (row[1] = window.min[1]; row[1] <= window.max[1]; ++row[1]) {
          row_end[1] = row[1];
          row_end[2] = row[2];
          level.slots.each_run(
              row, row_end, [&](std::uint32_t first, std::uint32_t last, std::uint32_t tag) {
                const std::uint32_t from = level.begin[first], to = level.begin[last + 1];
                if (from != to) scan(boxes + from, to - from, tag);
              });
        }
    });
  }

  /// The boxes of a level with each other. Each searches only backwards: the cells before its own
  /// in the order z, y, x, and the boxes before it in its own cell.
  template <class Add>
  void look_up_within(Structure& s, Level& level, Add add) {
    sort(s, level);
    const PackedBox* boxes = s.packed.data() + level.first;
    for_parts(0, level.count, [&](std::uint32_t i, std::size_t part) {
      const PackedBox& box = boxes[i];
      const ScannedBox query = scanned(box, *s.boxes);
      const auto scan = [&](const PackedBox* others, std::uint32_t n, std::uint32_t tag) {
        scan_.each_overlap(query, {others, n}, *s.boxes, part, [&](const PackedBox& other) {
          if (!is_tagged(level) || other.tag == tag) add(part, box.id, other.id);
        });
      };
      if (!level.sorted) return scan(boxes, i, 0);
      const Window window = window_of(level, box);
      const Cell own = level.cell(box);
      Cell row = window.min, row_end = window.max;
      for (row[2] = window.min[2]; row[2] <= own[2]; ++row[2]) {
        const std::int32_t last_y = row[2] < own[2] ? window.max[1] : own[1];
        for (row[1] = window.min[1]; row[1] <= last_y; ++row[1]) {
          const bool own_row = row[2] == own[2] && row[1] == own[1];
          row_end = {own_row ? own[0] : window.max[0], row[1], row[2]};
          const std::uint32_t own_slot = level.slots.slot(own), own_tag = level.slots.tag(own);
          level.slots.each_run(
              row, row_end, [&](std::uint32_t first, std::uint32_t last, std::uint32_t tag) {
                const std::uint32_t from = level.begin[first];
                const std::uint32_t to =
                    own_row && last == own_slot && tag == own_tag ? i : level.begin[last + 1];
                if (from < to) scan(boxes + from, to - from, tag);
              });
        }
      }
    });
  }

  /// The cells that may contain the lower corner of a box that overlaps this one.
  static Window window_of(const Level& level, const PackedBox& box) {
    Window w;
    for (int k = 0; k < 3; ++k) {
      w.min[k] = std::max(level.min[k], level.cell(box.lo[k] - level.reach));
      w.max[k] = std::min(level.max[k], level.cell(-box.minus_hi[k]));
    }
    return w;
  }

  static bool is_tagged(const Level& level) { return Slots::kTagged && level.sorted; }

  double relative_cell_;
  double cell_ = 0.0;
  FloatMap map_;
  BoxScan scan_;
  std::vector<PackedBox> packed_;
  std::vector<std::int16_t> levels_of_;
  std::vector<std::uint32_t> counts_, slot_of_;
};

}  // namespace selvedge::detail
