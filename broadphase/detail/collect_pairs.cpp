// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/collect_pairs.h>
#include <selvedge/broadphase/detail/raw_array.h>
#include <selvedge/broadphase/detail/sort_rows.h>
#include <selvedge/core/base/parallel.h>

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

namespace selvedge::detail {
namespace {

// A bucket is a range of first indices. A larger number of buckets would exceed the cache lines
// that can be written at the same time.
constexpr std::size_t kBuckets = 128;
// Up to this number, more buckets are still faster than keys that exceed 32 bits.
constexpr std::size_t kMostBuckets = 1024;
constexpr std::size_t kBucketGrain = 4;  // buckets that one task sorts with the same scratch
// Keys are counted and distributed from this many places of a list in turn, each with counters of
// its own. Consecutive keys mostly have the same first index; with common counters, each increment
// would wait for the previous one.
constexpr std::size_t kStreams = 2;
constexpr std::size_t kFewPairs = 1024;  // below this number plain sorting is faster

std::uint32_t first_of(std::uint64_t key) { return static_cast<std::uint32_t>(key >> 32); }

template <class Pair>
Pair pair_of(std::uint64_t key) {
  return {static_cast<std::int32_t>(key >> 32), static_cast<std::int32_t>(key & 0xffffffffu)};
}

/// Encodes a pair of one bucket as a short key: (first - base) << second_bits | second.
struct ShortKeys {
  int shift, second_bits;

  ShortKeys(std::size_t firsts, std::size_t seconds)
      : shift(static_cast<int>(std::bit_width((std::max<std::size_t>(firsts, 1) - 1) / kBuckets))),
        second_bits(static_cast<int>(std::bit_width(seconds))) {
    while (!fits_32_bits() && shift > 0 && firsts >> (shift - 1) < kMostBuckets) --shift;
  }
  bool fits_32_bits() const { return shift + second_bits <= 32; }
  std::size_t rows() const { return std::size_t{1} << shift; }
  std::size_t bucket(std::uint64_t key) const { return first_of(key) >> shift; }

  template <class Key>
  Key pack(std::uint64_t key) const {
    const Key row = first_of(key) & ((1u << shift) - 1u);
    return static_cast<Key>(row << second_bits | static_cast<std::uint32_t>(key));
  }
  template <class Key>
  std::size_t row(Key key) const {
    return static_cast<std::size_t>(key >> second_bits);
  }
  template <class Key>
  std::uint32_t second(Key key) const {
    return static_cast<std::uint32_t>(key & ((Key{1} << second_bits) - 1));
  }
};

/// Calls visit(stream, i) for all i below n: stream s visits its part in order, and the streams
/// take turns.
template <class Visit>
void each_in_streams(std::size_t n, Visit visit) {
  const std::size_t part = n / kStreams;
  for (std::size_t i = 0; i < part; ++i)
    for (std::size_t s = 0; s < kStreams; ++s) visit(s, s * part + i);
  for (std::size_t i = kStreams * part; i < n; ++i) visit(kStreams - 1, i);
}

/// Scratch memory for sorting buckets in turn.
struct BucketScratch {
  std::vector<std::uint32_t> begin, next, digits;
  RawArray<std::uint32_t> second;
};

/// Sorts one bucket: distributes its keys to their rows, then sorts each row.
template <class Key, class Pair>
void sort_bucket(std::span<const Key> keys, const ShortKeys& short_keys, std::int32_t base,
                 SortRows<Pair> sort_rows, BucketScratch& scratch, Pair* out) {
  const std::size_t rows = short_keys.rows();
  std::vector<std::uint32_t>&begin = scratch.begin, &next = scratch.next;
  begin.resize(rows + 1);
  // next[row · kStreams + stream]: first the number of keys, then their next free place.
  next.assign(rows * kStreams, 0);
  each_in_streams(keys.size(), [&](std::size_t stream, std::size_t i) {
    ++next[short_keys.row(keys[i]) * kStreams + stream];
  });
  std::uint32_t sum = 0;
  for (std::size_t r = 0; r < rows; ++r) {
    begin[r] = sum;
    for (std::size_t s = 0; s < kStreams; ++s) sum += std::exchange(next[r * kStreams + s], sum);
  }
  begin[rows] = sum;
  if (scratch.second.size() < keys.size() + kRowSlack)
    scratch.second.reset(keys.size() + keys.size() / 2 + kRowSlack);
  std::uint32_t* second = scratch.second.data();
  each_in_streams(keys.size(), [&](std::size_t stream, std::size_t i) {
    second[next[short_keys.row(keys[i]) * kStreams + stream]++] = short_keys.second(keys[i]);
  });
  for (std::size_t r = 0; r < rows; ++r) {
    const std::span<std::uint32_t> row(second + begin[r], begin[r + 1] - begin[r]);
    if (row.size() > kLongRow) sort_long_row(row, short_keys.second_bits, scratch.digits);
  }
  sort_rows({begin.data(), rows, second, base}, out);
}

}  // namespace

template <class Pair>
void PairCollector::sort_into(const std::vector<FoundPairs>& parts, PairBuffer FoundPairs::*list,
                              std::size_t firsts, std::size_t seconds, std::vector<Pair>& out) {
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
  if (ShortKeys(firsts, seconds).fits_32_bits())
    sort_by_buckets(parts, list, firsts, seconds, scratch_, out);
  else
    sort_by_buckets(parts, list, firsts, seconds, long_scratch_, out);
}

template <class Key, class Pair>
void PairCollector::sort_by_buckets(const std::vector<FoundPairs>& parts,
                                    PairBuffer FoundPairs::*list, std::size_t firsts,
                                    std::size_t seconds, std::vector<Key>& scratch,
                                    std::vector<Pair>& out) {
  const ShortKeys keys(firsts, seconds);
  const std::size_t buckets = (firsts >> keys.shift) + 1;
  // start[(part · buckets + bucket) · kStreams + stream]: first the number of pairs, then their
  // position.
  const std::size_t counters = buckets * kStreams;
  std::vector<std::size_t> start(parts.size() * counters, 0);
  parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const PairBuffer& found = parts[p].*list;
      const std::uint64_t* key = found.data();
      std::size_t* count = start.data() + p * counters;
      each_in_streams(found.size(), [&](std::size_t stream, std::size_t i) {
        ++count[keys.bucket(key[i]) * kStreams + stream];
      });
    }
  });
  std::vector<std::size_t> bucket_begin(buckets + 1, 0);
  std::size_t sum = 0;
  for (std::size_t b = 0; b < buckets; ++b) {
    bucket_begin[b] = sum;
    for (std::size_t p = 0; p < parts.size(); ++p)
      for (std::size_t s = 0; s < kStreams; ++s)
        sum += std::exchange(start[p * counters + b * kStreams + s], sum);
    if (sum - bucket_begin[b] > std::numeric_limits<std::uint32_t>::max())
      throw std::length_error("broad phase: more than 2^32 pairs of " +
                              std::to_string(keys.rows()) + " primitives");
  }
  bucket_begin[buckets] = sum;
  if (scratch.size() < sum) scratch.resize(sum);
  parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const PairBuffer& found = parts[p].*list;
      const std::uint64_t* key = found.data();
      std::size_t* next = start.data() + p * counters;
      each_in_streams(found.size(), [&](std::size_t stream, std::size_t i) {
        scratch[next[keys.bucket(key[i]) * kStreams + stream]++] = keys.pack<Key>(key[i]);
      });
    }
  });
  const SortRows<Pair> sort_rows = best_sort_rows<Pair>();
  parallel_for(buckets, kBucketGrain, [&](std::size_t begin, std::size_t end) {
    BucketScratch room;
    for (std::size_t b = begin; b < end; ++b)
      sort_bucket<Key, Pair>(
          {scratch.data() + bucket_begin[b], scratch.data() + bucket_begin[b + 1]}, keys,
          static_cast<std::int32_t>(b << keys.shift), sort_rows, room,
          out.data() + bucket_begin[b]);
  });
}

void PairCollector::collect(const std::vector<FoundPairs>& parts, PairBuffer FoundPairs::*list,
                            std::size_t firsts, std::size_t seconds,
                            std::vector<PointTrianglePair>& out) {
  sort_into(parts, list, firsts, seconds, out);
}

void PairCollector::collect(const std::vector<FoundPairs>& parts, PairBuffer FoundPairs::*list,
                            std::size_t firsts, std::size_t seconds,
                            std::vector<EdgeEdgePair>& out) {
  sort_into(parts, list, firsts, seconds, out);
}

void PairCollector::collect(const std::vector<FoundPairs>& parts, const SurfaceView& a,
                            const SurfaceView* b, CandidatePairs& out) {
  const SurfaceView& other = b ? *b : a;
  collect(parts, &FoundPairs::point_triangle, a.x_t0.size(), other.triangles.size(),
          out.point_triangle);
  if (b)
    collect(parts, &FoundPairs::triangle_point, b->x_t0.size(), a.triangles.size(),
            out.triangle_point);
  else
    out.triangle_point.clear();
  collect(parts, &FoundPairs::edge_edge, a.edges.size(), other.edges.size(), out.edge_edge);
}

}  // namespace selvedge::detail
