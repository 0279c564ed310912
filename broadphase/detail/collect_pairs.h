// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/pair_tally.h>
#include <selvedge/core/base/collision_types.h>

#include <cstdint>
#include <vector>

namespace selvedge::detail {

/// Pairs in the order in which they are found, each as first << 32 | second.
class PairBuffer {
 public:
  /// Maximum memory of a pair from its discovery to the result: 16 bytes here (a buffer doubles), 8
  /// more while it moves to a larger buffer or into its bucket, 16 while its bucket is sorted, and
  /// 8 in the result.
  static constexpr std::size_t kBytesPerPair = 48;

  void clear() { start(nullptr); }
  /// Clears the buffer. From now on it reports the pairs to `tally` before it grows.
  void start(PairTally* tally) {
    size_ = counted_ = 0;
    tally_ = tally;
  }
  /// Reports the remaining pairs to the tally and releases it. Throws BudgetExceeded.
  void finish() {
    count();
    tally_ = nullptr;
  }
  std::size_t size() const { return size_; }
  const std::uint64_t* data() const { return keys_.data(); }
  std::size_t bytes() const { return keys_.capacity() * sizeof(std::uint64_t); }

  /// Space for `n` more pairs; write there, then call advance_to with the end of the written part.
  std::uint64_t* room(std::size_t n) {
    if (size_ + n > keys_.size()) grow(n);
    return keys_.data() + size_;
  }
  void advance_to(const std::uint64_t* end) {
    size_ = static_cast<std::size_t>(end - keys_.data());
  }

 private:
  void grow(std::size_t n) {
    count();
    keys_.resize(2 * keys_.size() + n);
  }
  void count() {
    if (tally_) tally_->add(size_ - counted_);
    counted_ = size_;
  }

  std::vector<std::uint64_t> keys_;
  std::size_t size_ = 0, counted_ = 0;
  PairTally* tally_ = nullptr;
};

/// The pairs that one part of a traversal finds.
struct FoundPairs {
  PairBuffer point_triangle, triangle_point, edge_edge;

  void start(PairTally* tally) {
    for (PairBuffer* list : {&point_triangle, &triangle_point, &edge_edge}) list->start(tally);
  }
  void finish() {
    for (PairBuffer* list : {&point_triangle, &triangle_point, &edge_edge}) list->finish();
  }
  std::size_t bytes() const {
    return point_triangle.bytes() + triangle_point.bytes() + edge_edge.bytes();
  }
};

/// Gathers the lists of all parts into one sorted list. Sorts by buckets of the first index, then
/// by rows of one first index within each bucket. Uses all threads; the result does not depend on
/// the division into parts. No pair may occur twice.
class PairCollector {
 public:
  /// `firsts` and `seconds` are upper bounds of the first and second indices.
  void collect(const std::vector<FoundPairs>& parts, PairBuffer FoundPairs::*list,
               std::size_t firsts, std::size_t seconds, std::vector<PointTrianglePair>& out);
  void collect(const std::vector<FoundPairs>& parts, PairBuffer FoundPairs::*list,
               std::size_t firsts, std::size_t seconds, std::vector<EdgeEdgePair>& out);
  /// All three lists of two surfaces; `b` is null for one surface with itself.
  void collect(const std::vector<FoundPairs>& parts, const SurfaceView& a, const SurfaceView* b,
               CandidatePairs& out);
  std::size_t bytes() const {
    return scratch_.capacity() * sizeof(std::uint32_t) +
           long_scratch_.capacity() * sizeof(std::uint64_t);
  }

 private:
  template <class Pair>
  void sort_into(const std::vector<FoundPairs>& parts, PairBuffer FoundPairs::*list,
                 std::size_t firsts, std::size_t seconds, std::vector<Pair>& out);

  template <class Key, class Pair>
  void sort_by_buckets(const std::vector<FoundPairs>& parts, PairBuffer FoundPairs::*list,
                       std::size_t firsts, std::size_t seconds, std::vector<Key>& scratch,
                       std::vector<Pair>& out);

  std::vector<std::uint32_t> scratch_;
  std::vector<std::uint64_t> long_scratch_;
};

}  // namespace selvedge::detail
