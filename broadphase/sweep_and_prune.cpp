// SPDX-License-Identifier: MIT
// Sweep and prune: boxes are sorted by their lower ends along the axis on which they vary most, and
// each is compared with those that begin before it ends: D. Baraff, Dynamic simulation of
// non-penetrating rigid bodies, 1992 [Baraff1992]; J. D. Cohen, M. C. Lin, D. Manocha, M. K.
// Ponamgi, I-COLLIDE, 1995 [Cohen1995]. Conservative: reports the same pairs as brute force.
//
// Deviations. No state is kept from step to step. [Cohen1995] repairs the order of the last step by
// insertion, which costs one swap per pair of ends that pass each other; cloth has too many of
// these, and a radix sort has a constant cost. Sweeping along a single axis compares all boxes of a
// slice, O(n^(5/3)) for a crumpled sheet. Space is therefore cut into columns along that axis, as
// in G. Capannini, T. Larsson, Adaptive collision culling for massive simulations by a parallel and
// context-aware sweep and prune algorithm, 2018 [Capannini2018] (there by recursion, here evenly),
// and each column is swept separately. A pair that shares several columns is reported in the one
// that holds the larger of its lower corners. Boxes that cover more than 64 columns are compared
// with all others instead. One case remains quadratic: boxes that crowd one column and overlap
// along the axis (a mesh thousands of times smaller than the typical edge).
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/box_scan.h>
#include <selvedge/broadphase/detail/grid_engine.h>

#include <cmath>
#include <limits>
#include <numeric>

namespace selvedge {
namespace {

using detail::DoubleBox;
using detail::PackedBox;
using detail::PairParts;
using detail::SurfaceBoxes;

constexpr std::int32_t kMostColumns = 64;  // of one box
/// Approximate number of points per column if they filled all columns.
constexpr double kPointsPerColumn = 16.0;
/// Number of boxes compared between two tests whether the next boxes begin too late.
constexpr std::uint32_t kChunk = 16;
/// Structures are rebuilt when the side of the columns has changed by more than this factor.
constexpr double kSimilar = 1.25;

/// Maps floats to unsigned integers in the same order.
std::uint32_t ordered_bits(float x) {
  const auto bits = Eigen::numext::bit_cast<std::uint32_t>(x + 0.0f);  // -0 becomes 0
  return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

/// Sorts by the upper half of each number; stable. `scratch` has the same length.
void radix_sort(std::vector<std::uint64_t>& keys, std::vector<std::uint64_t>& scratch) {
  constexpr int digit_bits = 11, digits = 3;
  constexpr std::size_t values = std::size_t{1} << digit_bits;
  scratch.resize(keys.size());
  std::array<std::array<std::uint32_t, values>, digits> place{};
  const auto digit = [](std::uint64_t key, int d) {
    return static_cast<std::size_t>(key >> (32 + d * digit_bits)) & (values - 1);
  };
  for (const std::uint64_t key : keys)
    for (int d = 0; d < digits; ++d) ++place[d][digit(key, d)];
  for (int d = 0; d < digits; ++d) {
    std::exclusive_scan(place[d].begin(), place[d].end(), place[d].begin(), std::uint32_t{0});
    for (const std::uint64_t key : keys) scratch[place[d][digit(key, d)]++] = key;
    keys.swap(scratch);
  }
}

/// The columns: `count` by `count` squares around the origin of the floats; the outermost are
/// unbounded. Their sides are along axes [1] and [2], their length along axis [0].
struct Columns {
  std::array<int, 3> axis{0, 1, 2};
  double side = 0.0, inverse_side = 0.0;
  std::int32_t count = 1;

  /// Index of the column along axis[k] that contains a float coordinate; monotone.
  std::int32_t at(float x) const {
    const double scaled = std::floor(static_cast<double>(x) * inverse_side) + count / 2;
    return static_cast<std::int32_t>(std::clamp(scaled, 0.0, count - 1.0));
  }
};

/// The columns that a box is in.
struct Reach {
  std::array<std::int32_t, 2> min, max;
  std::int32_t count() const { return (max[0] - min[0] + 1) * (max[1] - min[1] + 1); }
};

class SweepEngine {
 public:
  /// The entries are sorted by column, then by lower end; the tag says, with a bit for each axis,
  /// whether the box began in an earlier column.
  using Structure = detail::ListedBoxes;

  explicit SweepEngine(const SweepAndPruneConfig& config) : column_(config.column) {}

  bool prepare(const SurfaceBoxes& a, const SurfaceBoxes* b) {
    std::vector<const std::vector<DoubleBox>*> lists{&a.points};
    if (b) lists.push_back(&b->points);
    const Vec3 middle = detail::middle_of(lists);
    Columns made;
    made.axis = axes_by_variance(lists, middle);
    const detail::FloatMap map(middle);
    made.side = column_ * detail::typical_extent(a, b, map);
    const auto points = static_cast<double>(a.points.size() + (b ? b->points.size() : 0));
    if (column_ > 0.0)
      made.count = static_cast<std::int32_t>(std::sqrt(points / kPointsPerColumn)) + 1;
    else
      made.side = 1.0;  // One unbounded column.
    made.inverse_side = std::min(1.0 / made.side, std::numeric_limits<double>::max());
    if (made.axis == columns_.axis && made.count == columns_.count &&
        made.side < kSimilar * columns_.side && columns_.side < kSimilar * made.side &&
        map_.is_near(map, made.side))
      return true;
    columns_ = made;
    map_ = map;
    return false;
  }

  void build(const std::vector<DoubleBox>& boxes, Structure& out) {
    out.pack(boxes, map_,
             [&](const PackedBox& box) { return reach_of(box).count() > kMostColumns; });
    keys_.resize(boxes.size());
    parallel_for(boxes.size(), detail::kBoxGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        keys_[i] = std::uint64_t{ordered_bits(out.all[i].lo[columns_.axis[0]])} << 32 | i;
    });
    radix_sort(keys_, scratch_);
    fill_columns(out);
  }

  void find_pairs(Structure& a, Structure& b, PairParts& out) {
    sweep(a, b, true,
          [&](std::size_t part, std::int32_t i, std::int32_t j) { out.add(part, i, j); });
    sweep(b, a, false,
          [&](std::size_t part, std::int32_t j, std::int32_t i) { out.add(part, i, j); });
    detail::find_wide_pairs(a, b, scan_, out);
  }

  void find_self_pairs(Structure& a, PairParts& out) {
    for_columns(a,
                [&](std::uint32_t column, std::uint32_t from, std::uint32_t to, std::size_t part) {
                  for (std::uint32_t i = from; i < to; ++i)
                    sweep_from(a, a.entries[i], a, {i + 1, a.begin[column + 1]}, part,
                               [&](std::int32_t x, std::int32_t y) { out.add(part, x, y); });
                });
    detail::find_wide_self_pairs(a, scan_, out);
  }

  std::size_t bytes() const {
    return (keys_.capacity() + scratch_.capacity()) * sizeof(std::uint64_t) + scan_.bytes();
  }

 private:
  /// The axes by variance, largest first. Uses distances from the middle, each limited to a
  /// thousand times the median distance, so that one far vertex does not determine the axis.
  static std::array<int, 3> axes_by_variance(
      const std::vector<const std::vector<DoubleBox>*>& lists, const Vec3& middle) {
    constexpr std::size_t most = 1024;
    Vec3 spread = Vec3::Zero();
    std::vector<double> sample;
    for (int k = 0; k < 3; ++k) {
      sample.clear();
      for (const std::vector<DoubleBox>* list : lists)
        for (std::size_t i = 0; i < list->size(); i += list->size() / most + 1)
          sample.push_back(std::abs((*list)[i].lo[k] - middle[k]));
      if (sample.empty()) continue;
      // The median distance replaces the standard deviation: equal for equal shapes, and robust.
      const auto place = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() / 2);
      std::nth_element(sample.begin(), place, sample.end());
      spread[k] = *place;
    }
    std::array<int, 3> axis{0, 1, 2};
    std::sort(axis.begin(), axis.end(),
              [&](int a, int b) { return spread[a] != spread[b] ? spread[a] > spread[b] : a < b; });
    return axis;
  }

  Reach reach_of(const PackedBox& box) const {
    Reach reach;
    for (int k = 0; k < 2; ++k) {
      reach.min[k] = columns_.at(box.lo[columns_.axis[k + 1]]);
      reach.max[k] = columns_.at(-box.minus_hi[columns_.axis[k + 1]]);
    }
    return reach;
  }

  template <class Visit>
  void each_column(const Reach& reach, Visit visit) const {
    for (std::int32_t y = reach.min[1]; y <= reach.max[1]; ++y)
      for (std::int32_t x = reach.min[0]; x <= reach.max[0]; ++x)
        visit(static_cast<std::size_t>(y) * columns_.count + x,
              static_cast<std::uint32_t>(x > reach.min[0]) |
                  static_cast<std::uint32_t>(y > reach.min[1]) << 1);
  }

  /// Puts the boxes, in the order of keys_, into their columns.
  void fill_columns(Structure& out) {
    const auto add = [&](const PackedBox& box, auto visit) {
      if (box.tag) return;
      each_column(reach_of(box), [&](std::size_t column, std::uint32_t began_before) {
        visit(column, box, began_before);
      });
    };
    detail::sort_into_slots(
        static_cast<std::size_t>(columns_.count) * columns_.count,
        [&](auto visit) {
          for (const PackedBox& box : out.all) add(box, visit);
        },
        [&](auto visit) {
          for (const std::uint64_t key : keys_) add(out.all[key & 0xffffffffu], visit);
        },
        out.begin, out.entries);
  }

  /// Calls work(column, from, to, part) for ranges of the entries, in parts.
  template <class Work>
  void for_columns(const Structure& s, Work work) {
    const std::size_t n = s.entries.size(), grain = detail::part_grain(n);
    parallel_for(n, grain, [&](std::size_t begin, std::size_t end) {
      auto column = static_cast<std::uint32_t>(
          std::upper_bound(s.begin.begin(), s.begin.end(), begin) - s.begin.begin() - 1);
      for (std::size_t from = begin; from < end; ++column) {
        const std::size_t to = std::min<std::size_t>(end, s.begin[column + 1]);
        if (from < to)
          work(column, static_cast<std::uint32_t>(from), static_cast<std::uint32_t>(to),
               begin / grain);
        from = std::max(from, to);
      }
    });
  }

  /// Each box of `a` against those of `b` that begin within it (if `equal`: or at the same place).
  template <class Add>
  void sweep(const Structure& a, const Structure& b, bool equal, Add add) {
    const int k = columns_.axis[0];
    for_columns(
        a, [&](std::uint32_t column, std::uint32_t from, std::uint32_t to, std::size_t part) {
          const PackedBox* sorted = b.entries.data();
          const std::uint32_t end = b.begin[column + 1];
          const auto begins_before = [&](const PackedBox& box, float lo) {
            return equal ? box.lo[k] < lo : box.lo[k] <= lo;
          };
          auto place =
              static_cast<std::uint32_t>(std::lower_bound(sorted + b.begin[column], sorted + end,
                                                          a.entries[from].lo[k], begins_before) -
                                         sorted);
          for (std::uint32_t i = from; i < to; ++i) {
            while (place < end && begins_before(sorted[place], a.entries[i].lo[k])) ++place;
            sweep_from(a, a.entries[i], b, {place, end}, part,
                       [&](std::int32_t x, std::int32_t y) { add(part, x, y); });
          }
        });
  }

  /// Entries of a column from a place on.
  struct Rest {
    std::uint32_t place, end;
  };

  /// One box of `a` against those entries of `b` that begin before it ends.
  template <class Found>
  void sweep_from(const Structure& a, const PackedBox& box, const Structure& b, Rest rest,
                  std::size_t part, Found found) {
    const int k = columns_.axis[0];
    const detail::ScannedBox query = detail::scanned(box, *a.boxes);
    for (; rest.place < rest.end && b.entries[rest.place].lo[k] <= query.packed.hi[k];
         rest.place += kChunk)
      scan_.each_overlap(query,
                         {b.entries.data() + rest.place, std::min(kChunk, rest.end - rest.place)},
                         *b.boxes, part, [&](const PackedBox& other) {
                           if ((box.tag & other.tag) == 0) found(box.id, other.id);
                         });
  }

  double column_;
  Columns columns_;
  detail::FloatMap map_;
  detail::BoxScan scan_;
  std::vector<std::uint64_t> keys_, scratch_;
};

}  // namespace

std::unique_ptr<BroadPhase> make_sweep_and_prune(const SweepAndPruneConfig& config) {
  if (config.column != 0.0) detail::checked_cell(config.column, "sweep_and_prune");
  return std::make_unique<detail::BoxPairDetector<SweepEngine>>(
      BroadPhaseTraits{.source = "boxes sorted along one axis, in columns; D. Baraff, Dynamic "
                                 "simulation of non-penetrating rigid bodies, 1992; J. D. Cohen, "
                                 "M. C. Lin, D. Manocha, M. K. Ponamgi, I-COLLIDE, 1995"},
      SweepEngine(config));
}

void register_sweep_and_prune(BroadPhaseRegistry& registry) {
  registry.add("sweep_and_prune", {}, [](const MethodOptions&) { return make_sweep_and_prune(); });
}

}  // namespace selvedge
