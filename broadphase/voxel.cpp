// SPDX-License-Identifier: MIT
// Voxels: space is cut into equal cubes, each of which lists all primitives whose boxes reach into
// it; a primitive is compared with the lists of the voxels that it reaches: D. Zhang, M. M. F.
// Yuen, Collision detection for clothed human animation, 2000 [ZhangYuen2000], as described in the
// survey [MozafaryPayvandy2016]. Conservative: reports the same pairs as brute force.
//
// The size of a voxel affects only the cost; the survey says that it affects the accuracy. The
// survey's rule is to choose voxels small enough for short lists, but not so small that a primitive
// reaches into many voxels. It has this form: a primitive of extent e reaches into (e/v + 1)³
// voxels of side v, and each list of a sheet of L layers holds about 3·L·(v/e + 1)² edges; the time
//   T(v) = (e/v + 1)³ · (c_voxel + 3·L·(v/e + 1)²·c_box)
// is least between 1.5 and 2 e if finding a voxel costs five comparisons of boxes (L from 1 to 4),
// and grows as (e/v)³ below and (v/e)² above. search_voxel measures it on given surfaces: sheets of
// 6,400 vertices have a flat optimum from 1.4 to 4 typical extents, twice the time at 0.5 and 1.4
// times at 8: large voxels cost less than the model predicts.
//
// Deviations from the paper. The voxels are slots of a hash table instead of an array over the
// body's box. A pair that shares several voxels is reported in the one that holds the larger of its
// lower corners. A primitive that reaches into more than 512 voxels, or 16 along an axis, is in no
// list and is compared with all others. The lists together have at most 512 entries per primitive,
// so that memory is bounded however far one vertex moves; a primitive that moves far costs one
// comparison with each other primitive. If many primitives are smaller than a sixteenth of a voxel
// (a mesh many times smaller than the other), the voxels are cubes of coordinates mapped by their
// quantiles. One case remains quadratic: many primitives dozens of times larger than the typical
// edge.
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/box_scan.h>
#include <selvedge/broadphase/detail/grid_engine.h>
#include <selvedge/core/base/internal/stopwatch.h>

#include <bit>

namespace selvedge {
namespace {

using detail::Cell;
using detail::DoubleBox;
using detail::PackedBox;
using detail::PairParts;
using detail::SurfaceBoxes;

constexpr std::int64_t kMostVoxels = 512;  // of one box
constexpr std::int32_t kMostAlong = 16;    // of one box along one axis
constexpr float kMostCells = 1 << 30;      // voxels further out count as the last one
constexpr double kFinest = 1.0 / 16.0;     // voxels: a voxel holds hundreds of smaller boxes
constexpr double kBestVoxel = 1.7;         // typical extents, see above

/// Distinguishes the entries of a slot. Two boxes that share a voxel reach into voxels less than
/// 2·kMostAlong apart, so nine bits of each coordinate are enough; the lowest three bits say along
/// which axes the box began before this voxel.
std::uint32_t tag_of(const Cell& voxel, const Cell& first) {
  std::uint32_t tag = 0;
  for (int k = 0; k < 3; ++k)
    tag |= static_cast<std::uint32_t>(voxel[k] > first[k]) << k |
           (static_cast<std::uint32_t>(voxel[k]) & 0x1ffu) << (3 + 9 * k);
  return tag;
}
/// True if two entries are of one voxel, and it contains the larger of their lower corners.
bool meet_here(std::uint32_t a, std::uint32_t b) { return (a ^ b) < 8u && (a & b & 7u) == 0; }

class VoxelEngine {
 public:
  struct Structure : detail::ListedBoxes {
    int bits = 1;  ///< of the number of a slot, which stands for some voxels
    bool listed = false;
  };

  explicit VoxelEngine(double voxel) : voxel_(voxel) {}

  bool prepare(const SurfaceBoxes& a, const SurfaceBoxes* b) {
    if (detail::place_cells(a, b, voxel_, kFinest, map_, side_)) return true;
    inverse_ = static_cast<float>(1.0 / side_);
    return false;
  }

  void build(const std::vector<DoubleBox>& boxes, Structure& out) {
    out.listed = false;
    out.pack(boxes, map_, [&](const PackedBox& box) { return is_wide(box); });
  }

  /// Only the second list is put into voxels, for example the body's triangles.
  void find_pairs(Structure& a, Structure& b, PairParts& out) {
    look_up(a, b, [&](std::size_t part, std::int32_t i, std::int32_t j) { out.add(part, i, j); });
    detail::find_wide_pairs(a, b, scan_, out);
  }

  void find_self_pairs(Structure& a, PairParts& out) {
    look_up(a, a, [&](std::size_t part, std::int32_t i, std::int32_t j) {
      if (i < j) out.add(part, i, j);
    });
    detail::find_wide_self_pairs(a, scan_, out);
  }

  std::size_t bytes() const { return scan_.bytes(); }

 private:
  Cell cell(float x, float y, float z) const {
    const auto along = [this](float c) {
      const float scaled = std::clamp(c * inverse_, -kMostCells, kMostCells);
      const auto whole = static_cast<std::int32_t>(scaled);
      return whole - (scaled < static_cast<float>(whole));
    };
    return {along(x), along(y), along(z)};
  }
  Cell first_voxel(const PackedBox& b) const { return cell(b.lo[0], b.lo[1], b.lo[2]); }
  Cell last_voxel(const PackedBox& b) const {
    return cell(-b.minus_hi[0], -b.minus_hi[1], -b.minus_hi[2]);
  }

  bool is_wide(const PackedBox& box) const {
    const Cell first = first_voxel(box), last = last_voxel(box);
    std::int64_t voxels = 1;
    for (int k = 0; k < 3; ++k) {
      const std::int64_t along = std::int64_t{last[k]} - first[k] + 1;
      if (along > kMostAlong) return true;
      voxels *= along;
    }
    return voxels > kMostVoxels;
  }

  /// Calls visit(voxel, tag) for the voxels of a box.
  template <class Visit>
  void each_voxel(const PackedBox& box, Visit visit) const {
    const Cell first = first_voxel(box), last = last_voxel(box);
    Cell v;
    for (v[2] = first[2]; v[2] <= last[2]; ++v[2])
      for (v[1] = first[1]; v[1] <= last[1]; ++v[1])
        for (v[0] = first[0]; v[0] <= last[0]; ++v[0]) visit(v, tag_of(v, first));
  }

  static std::size_t slot_of(const Cell& v, int bits) {
    // [Teschner2003] section 4.1, then the upper bits of a multiple by 2^32 over the golden ratio.
    const std::uint32_t hash = static_cast<std::uint32_t>(v[0]) * 73856093u ^
                               static_cast<std::uint32_t>(v[1]) * 19349663u ^
                               static_cast<std::uint32_t>(v[2]) * 83492791u;
    return hash * 2654435769u >> (32 - bits);
  }

  void list(Structure& s) const {
    if (s.listed) return;
    s.bits = std::clamp(static_cast<int>(std::bit_width(2 * s.all.size())), 1, 31);
    const auto each = [&](auto visit) {
      for (const PackedBox& box : s.all)
        if (!box.tag)
          each_voxel(
              box, [&](const Cell& v, std::uint32_t tag) { visit(slot_of(v, s.bits), box, tag); });
    };
    detail::sort_into_slots(std::size_t{1} << s.bits, each, each, s.begin, s.entries);
    s.listed = true;
  }

  /// The boxes of `a` with the lists of `b`.
  template <class Add>
  void look_up(const Structure& a, Structure& b, Add add) {
    list(b);
    const std::size_t grain = detail::part_grain(a.all.size());
    parallel_for(a.all.size(), grain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        if (!a.all[i].tag) look_up_one(a, a.all[i], b, begin / grain, add);
    });
  }

  template <class Add>
  void look_up_one(const Structure& a, const PackedBox& box, const Structure& b, std::size_t part,
                   const Add& add) {
    const detail::ScannedBox query = detail::scanned(box, *a.boxes);
    each_voxel(box, [&](const Cell& v, std::uint32_t tag) {
      const std::size_t slot = slot_of(v, b.bits);
      scan_.each_overlap(query,
                         {b.entries.data() + b.begin[slot], b.begin[slot + 1] - b.begin[slot]},
                         *b.boxes, part, [&](const PackedBox& other) {
                           if (meet_here(tag, other.tag)) add(part, box.id, other.id);
                         });
    });
  }

  double voxel_;
  double side_ = 0.0;
  float inverse_ = 1.0f;
  detail::FloatMap map_;
  detail::BoxScan scan_;
};

/// Time of the second of two calls, s: the cost of a later step.
double seconds_of(BroadPhase& detector, const SurfaceView& a, const SurfaceView* b) {
  CandidatePairs out;
  double seconds = 0.0;
  for (int call = 0; call < 2; ++call) {
    const Stopwatch watch;
    if (b)
      detector.find_pairs(a, *b, out);
    else
      detector.find_self_pairs(a, out);
    seconds = watch.seconds();
  }
  return seconds;
}

}  // namespace

std::unique_ptr<BroadPhase> make_voxel(const VoxelConfig& config) {
  if (config.voxel != 0.0) detail::checked_cell(config.voxel, "voxel");
  return std::make_unique<detail::BoxPairDetector<VoxelEngine>>(
      BroadPhaseTraits{.source =
                           "cubes with lists of the primitives in them; D. Zhang, M. M. F. Yuen, "
                           "Collision detection for clothed human animation, 2000"},
      VoxelEngine(config.voxel > 0.0 ? config.voxel : kBestVoxel));
}

std::vector<VoxelTrial> search_voxel(const SurfaceView& a, const SurfaceView* b) {
  std::vector<VoxelTrial> trials;
  for (const double voxel : {0.5, 0.7, 1.0, 1.4, 1.7, 2.0, 2.8, 4.0, 5.6, 8.0}) {
    const auto detector = make_voxel({.voxel = voxel});
    trials.push_back({voxel, seconds_of(*detector, a, b), detector->last_cost().bytes});
  }
  std::stable_sort(trials.begin(), trials.end(),
                   [](const VoxelTrial& x, const VoxelTrial& y) { return x.seconds < y.seconds; });
  return trials;
}

void register_voxel(BroadPhaseRegistry& registry) {
  registry.add("voxel",
               {{.name = "voxel",
                 .initial = VoxelConfig{}.voxel,
                 .unit = "1",
                 .least = 0.0,
                 .most = 1e6,
                 .meaning = "side of a voxel relative to the typical extent of an edge's box; "
                            "smaller: shorter lists in more voxels; 0: 1.7, the optimum of the "
                            "cost model"}},
               [](const MethodOptions& o) { return make_voxel({.voxel = o["voxel"]}); });
}

}  // namespace selvedge
