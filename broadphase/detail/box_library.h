// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/detail/collect_pairs.h>
#include <selvedge/core/base/parallel.h>

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

/// A closed box in the form that a box library receives.
///
/// Why float loses nothing: every coordinate d of a double box, lower or upper, of both surfaces
/// goes through the same map m(d) = clamp(float(d - origin)), whose roundings are monotone. So
/// lo(a) <= hi(b) in double implies m(lo(a)) <= m(hi(b)). And m(lo(a)) < m(hi(b)) implies lo(a) <
/// hi(b), so only pairs that are equal in some coordinate must be tested again in double. The clamp
/// keeps products of three sizes finite in float.
struct UnitBox {
  std::array<float, 3> lo, hi;
};

/// Receives the pairs of boxes that a library finds, in any order and from any number of threads,
/// and forwards them a few thousand at a time, so that storing them takes little memory.
class UnitPairs {
 public:
  /// Expands pairs of boxes, each first << 32 | second, to pairs of primitives.
  using Expand = FunctionRef<void(std::span<const std::uint64_t> pairs, FoundPairs& out)>;

  /// `expand` and `tally` must outlive this object.
  UnitPairs(Expand expand, PairTally& tally, std::vector<FoundPairs>& parts);
  UnitPairs(const UnitPairs&) = delete;
  UnitPairs& operator=(const UnitPairs&) = delete;

  void add(std::uint32_t first, std::uint32_t second) {
    List& list = mine();
    list.pairs[list.count] = std::uint64_t{first} << 32 | second;
    if (++list.count == kMost) flush(list);
  }
  /// True once there are more pairs than the budget allows: the library may stop. No exception
  /// propagates through the library.
  bool stopped() const { return stopped_.load(std::memory_order_relaxed); }
  /// Call last, when all threads have finished. Throws BudgetExceeded. Afterwards the parts contain
  /// the pairs.
  void finish();

 private:
  static constexpr std::size_t kMost = 4096;  // 32 KiB per thread: a first-level cache
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
  const std::uint64_t run_;  ///< unique in the program, so that a thread recognises a new run
  std::mutex mutex_;
  std::deque<List> lists_;
  std::atomic<bool> stopped_{false};
  std::optional<BudgetExceeded> failure_;
};

/// Number of surfaces whose structures a library keeps: those of the current call and two older
/// ones.
inline constexpr int kBoxSlots = 4;

/// Interface that a library implements to become a broad phase. It keeps one structure per slot.
class BoxLibrary {
 public:
  virtual ~BoxLibrary() = default;

  /// Builds the structure of a slot from scratch. The boxes stay in place, unchanged, until the
  /// next build or refit of that slot. `stays`: the surface is static, so the boxes will not
  /// change.
  virtual void build(int slot, std::span<const UnitBox> boxes, bool stays) = 0;
  /// Fits the structure to new boxes, the same number as before. Returns false if it must be
  /// rebuilt.
  virtual bool refit(int slot, std::span<const UnitBox> boxes) = 0;
  /// Reports every pair of overlapping boxes (i of a, j of b). Additional pairs are harmless,
  /// repeated ones are not.
  virtual void find(int slot_a, int slot_b, UnitPairs& out) = 0;
  /// Reports every pair of different overlapping boxes of one slot once, i and j in either order.
  virtual void find_self(int slot, UnitPairs& out) = 0;
  /// Memory kept, in bytes, as far as the library reports it.
  virtual std::size_t bytes() const = 0;
  virtual BroadPhaseTraits traits() const = 0;
};

/// Makes a broad phase from a library that finds overlapping boxes. The library receives one box
/// per triangle. Every vertex and every edge belongs to one triangle [Curtis2008], so the pairs of
/// boxes expand to each pair of primitives once, which is then tested in double: the result is that
/// of brute force, bit for bit. Surfaces are kept as in bvh_aabb: one with known triangles is
/// refitted, one with a known nonzero static_id costs nothing.
std::unique_ptr<BroadPhase> make_box_broad_phase(std::unique_ptr<BoxLibrary> library);

}  // namespace selvedge::detail
