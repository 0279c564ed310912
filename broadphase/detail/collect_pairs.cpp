// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/collect_pairs.h>
#include <selvedge/core/parallel.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <stdexcept>
#include <string>

namespace selvedge::detail {
namespace {

constexpr std::size_t kBuckets = 128;      // more would not fit the cache lines that are written
constexpr std::size_t kFewPairs = 1024;    // below, plain sorting is quicker
constexpr std::ptrdiff_t kShortList = 32;  // below, insertion sort is quicker

std::uint32_t first_of(std::uint64_t key) { return static_cast<std::uint32_t>(key >> 32); }

template <class Pair>
Pair pair_of(std::uint64_t key) {
  return {static_cast<std::int32_t>(key >> 32), static_cast<std::int32_t>(key & 0xffffffffu)};
}

void sort_seconds(std::uint32_t* begin, std::uint32_t* end) {
  if (end - begin > kShortList) {
    std::sort(begin, end);
    return;
  }
  for (std::uint32_t* i = begin + 1; i < end; ++i) {
    const std::uint32_t value = *i;
    std::uint32_t* j = i;
    for (; j > begin && *(j - 1) > value; --j) *j = *(j - 1);
    *j = value;
  }
}

/// Sorts one bucket: counts by first index, deals out the seconds, sorts each short list.
template <class Pair>
void sort_bucket(const std::uint64_t* keys, std::size_t n, std::uint32_t first, std::size_t width,
                 Pair* out) {
  std::vector<std::uint32_t> next(width + 1, 0), seconds(n);
  for (std::size_t i = 0; i < n; ++i) ++next[first_of(keys[i]) - first + 1];
  for (std::size_t i = 0; i < width; ++i) next[i + 1] += next[i];
  for (std::size_t i = 0; i < n; ++i)
    seconds[next[first_of(keys[i]) - first]++] = static_cast<std::uint32_t>(keys[i]);
  // Now next[i] is the end of list i.
  std::uint32_t begin = 0;
  for (std::size_t i = 0; i < width; ++i) {
    const std::uint32_t end = next[i];
    if (begin == end) continue;
    sort_seconds(seconds.data() + begin, seconds.data() + end);
    for (; begin < end; ++begin)
      out[begin] = {static_cast<std::int32_t>(first + i),
                    static_cast<std::int32_t>(seconds[begin])};
  }
}

}  // namespace

template <class Pair>
void PairCollector::sort_into(const std::vector<FoundPairs>& parts, PairBuffer FoundPairs::*list,
                              std::size_t firsts, std::vector<Pair>& out) {
  std::size_t total = 0;
  for (const FoundPairs& part : parts) total += (part.*list).size();
  out.resize(total);
  if (total < kFewPairs) {
    auto next = out.begin();
    for (const FoundPairs& part : parts)
      next = std::transform((part.*list).data(), (part.*list).data() + (part.*list).size(), next,
                            pair_of<Pair>);
    std::sort(out.begin(), out.end());
    return;
  }
  if (scratch_.size() < total) scratch_.resize(total);

  const int shift =
      static_cast<int>(std::bit_width((std::max<std::size_t>(firsts, 1) - 1) / kBuckets));
  const std::size_t buckets = (firsts >> shift) + 1;
  // start[part·buckets + bucket], first how many, then where they go.
  std::vector<std::size_t> start(parts.size() * buckets, 0);
  parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const PairBuffer& found = parts[p].*list;
      std::size_t* count = start.data() + p * buckets;
      for (std::size_t i = 0; i < found.size(); ++i) ++count[first_of(found.data()[i]) >> shift];
    }
  });
  std::vector<std::size_t> bucket_begin(buckets + 1, 0);
  std::size_t sum = 0;
  for (std::size_t b = 0; b < buckets; ++b) {
    bucket_begin[b] = sum;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const std::size_t count = start[p * buckets + b];
      start[p * buckets + b] = sum;
      sum += count;
    }
    if (sum - bucket_begin[b] > std::numeric_limits<std::uint32_t>::max())
      throw std::length_error("broad phase: more than 2^32 pairs of " +
                              std::to_string(std::size_t{1} << shift) + " primitives");
  }
  bucket_begin[buckets] = sum;
  parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const PairBuffer& found = parts[p].*list;
      std::size_t* next = start.data() + p * buckets;
      for (std::size_t i = 0; i < found.size(); ++i) {
        const std::uint64_t key = found.data()[i];
        scratch_[next[first_of(key) >> shift]++] = key;
      }
    }
  });
  parallel_for(buckets, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b)
      sort_bucket(scratch_.data() + bucket_begin[b], bucket_begin[b + 1] - bucket_begin[b],
                  static_cast<std::uint32_t>(b << shift), std::size_t{1} << shift,
                  out.data() + bucket_begin[b]);
  });
}

void PairCollector::collect(const std::vector<FoundPairs>& parts, PairBuffer FoundPairs::*list,
                            std::size_t firsts, std::vector<PointTrianglePair>& out) {
  sort_into(parts, list, firsts, out);
}

void PairCollector::collect(const std::vector<FoundPairs>& parts, PairBuffer FoundPairs::*list,
                            std::size_t firsts, std::vector<EdgeEdgePair>& out) {
  sort_into(parts, list, firsts, out);
}

}  // namespace selvedge::detail
