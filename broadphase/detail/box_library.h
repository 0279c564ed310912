// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/collect_pairs.h>
#include <selvedge/core/parallel.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace selvedge::detail {

/// A closed box as a library of boxes is given it.
///
/// Why float loses nothing: every coordinate d of a double box, lower or upper, of both surfaces
/// goes through the same map m(d) = clamp(float(d - origin)), whose roundings are monotone. So
/// lo(a) <= hi(b) in double implies m(lo(a)) <= m(hi(b)). And m(lo(a)) < m(hi(b)) implies
/// lo(a) < hi(b), so that only pairs equal in some coordinate must be looked at again in double.
/// The clamp keeps products of three sizes finite in float.
struct UnitBox {
  std::array<float, 3> lo, hi;
};

/// Takes the pairs of boxes that a library finds, in any order and from any number of threads, and
/// hands them on a few thousand at a time, so that their number takes no memory.
class UnitPairs {
 public:
  /// Makes pairs of primitives out of pairs of boxes, each first << 32 | second.
  using Expand = FunctionRef<void(std::span<const std::uint64_t> pairs, FoundPairs& out)>;

  /// Must outlive `expand` and `tally`.
  UnitPairs(Expand expand, PairTally& tally, std::vector<FoundPairs>& parts);
  UnitPairs(const UnitPairs&) = delete;
  UnitPairs& operator=(const UnitPairs&) = delete;

  void add(std::uint32_t first, std::uint32_t second) {
    List& list = mine();
    list.pairs[list.count] = std::uint64_t{first} << 32 | second;
    if (++list.count == kMost) flush(list);
  }
  /// True once there are more pairs than the budget allows: the library may stop. No exception
  /// passes through it.
  bool stopped() const { return stopped_.load(std::memory_order_relaxed); }
  /// Call last, when all threads are done; throws BudgetExceeded. Afterwards the pairs lie in the
  /// parts.
  void finish();

 private:
  static constexpr std::size_t kMost = 4096;  // 32 KiB a thread: a first-level cache
  struct List {
    std::array<std::uint64_t, kMost> pairs;
    std::size_t count = 0;
    FoundPairs found;
  };

  List& mine() {
    thread_local std::uint64_t run = 0;
    thread_local List* list = nullptr;
    if (run != run_) {
      list = &new_list();
      run = run_;
    }
    return *list;
  }
  List& new_list();
  void flush(List& list);

  Expand expand_;
  PairTally& tally_;
  std::vector<FoundPairs>& parts_;
  const std::uint64_t run_;  ///< unique in the program, so that a thread knows a new run by it
  std::mutex mutex_;
  std::deque<List> lists_;
  std::atomic<bool> stopped_{false};
  std::optional<BudgetExceeded> failure_;
};

/// How many surfaces a library keeps its structures of: those of a call and two older ones.
inline constexpr int kBoxSlots = 4;

/// What a library has to do to become a broad phase. It keeps one structure for each slot.
class BoxLibrary {
 public:
  virtual ~BoxLibrary() = default;

  /// Makes the structure of a slot anew. The boxes stay where they are, and unchanged, until the
  /// next build or refit of that slot. `stays` says that the boxes are promised not to move.
  virtual void build(int slot, std::span<const UnitBox> boxes, bool stays) = 0;
  /// Fits the structure to new boxes, as many as before; false if it has to be built anew.
  virtual bool refit(int slot, std::span<const UnitBox> boxes) = 0;
  /// Every pair of overlapping boxes (i of a, j of b); more pairs do no harm, repeated ones do.
  virtual void find(int slot_a, int slot_b, UnitPairs& out) = 0;
  /// Every pair of overlapping boxes of one slot, once, i and j in either order and different.
  virtual void find_self(int slot, UnitPairs& out) = 0;
  /// Memory that is kept, as far as the library tells.
  virtual std::size_t bytes() const = 0;
  virtual BroadPhaseTraits traits() const = 0;
};

/// A broad phase out of a library that finds overlapping boxes. The library is given one box per
/// triangle; every vertex and every edge belongs to one triangle [Curtis2008], so that the pairs of
/// boxes are expanded to each pair of primitives once, and tested in double: the result is that of
/// brute force, bit for bit. Surfaces are kept as the tree of bvh_aabb keeps them: one whose
/// triangles were seen before is refitted, one whose nonzero static_id was seen before costs
/// nothing.
std::unique_ptr<BroadPhase> make_box_broad_phase(std::unique_ptr<BoxLibrary> library);

}  // namespace selvedge::detail
