// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>

#include <cstdint>
#include <vector>

namespace selvedge::detail {

/// Pairs in the order in which they are found, each as first << 32 | second.
class PairBuffer {
 public:
  void clear() { size_ = 0; }
  std::size_t size() const { return size_; }
  const std::uint64_t* data() const { return keys_.data(); }
  std::size_t bytes() const { return keys_.capacity() * sizeof(std::uint64_t); }

  /// Room for `n` more; write there, then call advance_to with the end of what was written.
  std::uint64_t* room(std::size_t n) {
    if (size_ + n > keys_.size()) keys_.resize(2 * keys_.size() + n);
    return keys_.data() + size_;
  }
  void advance_to(const std::uint64_t* end) {
    size_ = static_cast<std::size_t>(end - keys_.data());
  }

 private:
  std::vector<std::uint64_t> keys_;
  std::size_t size_ = 0;
};

/// What one part of a traversal finds.
struct FoundPairs {
  PairBuffer point_triangle, triangle_point, edge_edge;

  void clear() {
    point_triangle.clear();
    triangle_point.clear();
    edge_edge.clear();
  }
  std::size_t bytes() const {
    return point_triangle.bytes() + triangle_point.bytes() + edge_edge.bytes();
  }
};

/// Gathers the lists of all parts into one sorted list. Sorting is by buckets of the first index,
/// then by the digits of both within each bucket: linear in the number of pairs, threaded, the same
/// list whatever the parts were.
class PairCollector {
 public:
  /// `firsts` and `seconds` bound the first and second indices from above.
  void collect(const std::vector<FoundPairs>& parts, PairBuffer FoundPairs::*list,
               std::size_t firsts, std::size_t seconds, std::vector<PointTrianglePair>& out);
  void collect(const std::vector<FoundPairs>& parts, PairBuffer FoundPairs::*list,
               std::size_t firsts, std::size_t seconds, std::vector<EdgeEdgePair>& out);
  std::size_t bytes() const {
    return (scratch_.capacity() + long_scratch_.capacity()) * sizeof(std::uint64_t) +
           short_scratch_.capacity() * sizeof(std::uint32_t);
  }

 private:
  template <class Pair>
  void sort_into(const std::vector<FoundPairs>& parts, PairBuffer FoundPairs::*list,
                 std::size_t firsts, std::size_t seconds, std::vector<Pair>& out);

  std::vector<std::uint64_t> scratch_, long_scratch_;
  std::vector<std::uint32_t> short_scratch_;
};

}  // namespace selvedge::detail
