// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/collect_pairs.h>
#include <selvedge/core/parallel.h>

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace selvedge::detail {
namespace {

constexpr std::size_t kBuckets = 128;    // more would not fit the cache lines that are written
constexpr std::size_t kFewPairs = 1024;  // below, plain sorting is quicker
constexpr int kDigitBits = 9;            // 512 counters of four bytes: half of a first-level cache
constexpr std::size_t kDigitValues = std::size_t{1} << kDigitBits;

std::uint32_t first_of(std::uint64_t key) { return static_cast<std::uint32_t>(key >> 32); }

template <class Pair>
Pair pair_of(std::uint64_t key) {
  return {static_cast<std::int32_t>(key >> 32), static_cast<std::int32_t>(key & 0xffffffffu)};
}

/// How a pair of one bucket becomes a short key: (first - base) << second_bits | second.
struct ShortKeys {
  std::uint32_t base;
  int second_bits, bits;

  template <class Key>
  Key pack(std::uint64_t key) const {
    return static_cast<Key>(static_cast<Key>(first_of(key) - base) << second_bits |
                            static_cast<std::uint32_t>(key));
  }
  template <class Pair, class Key>
  Pair unpack(Key key) const {
    const Key mask = (Key{1} << second_bits) - 1;
    return {static_cast<std::int32_t>(base + static_cast<std::uint32_t>(key >> second_bits)),
            static_cast<std::int32_t>(key & mask)};
  }
};

/// Sorts one bucket by its short keys, lowest digit first. `scratch` holds 2·n keys.
template <int digits, class Key, class Pair>
void sort_bucket(const std::uint64_t* found, std::size_t n, const ShortKeys& short_keys,
                 Key* scratch, Pair* out) {
  const auto digit = [](Key key, int d) {
    return static_cast<std::size_t>(key >> (d * kDigitBits)) & (kDigitValues - 1);
  };
  std::array<std::array<std::uint32_t, kDigitValues>, digits> next;
  for (auto& counts : next) counts.fill(0);
  for (std::size_t i = 0; i < n; ++i) {
    const Key key = short_keys.pack<Key>(found[i]);
    for (int d = 0; d < digits; ++d) ++next[d][digit(key, d)];
  }
  for (int d = 0; d < digits; ++d) {
    std::uint32_t sum = 0;
    for (std::uint32_t& place : next[d]) sum += std::exchange(place, sum);
  }
  Key *from = scratch, *to = scratch + n;
  for (std::size_t i = 0; i < n; ++i) {
    const Key key = short_keys.pack<Key>(found[i]);
    from[next[0][digit(key, 0)]++] = key;
  }
  for (int d = 1; d + 1 < digits; ++d, std::swap(from, to))
    for (std::size_t i = 0; i < n; ++i) to[next[d][digit(from[i], d)]++] = from[i];
  for (std::size_t i = 0; i < n; ++i)
    out[next[digits - 1][digit(from[i], digits - 1)]++] = short_keys.unpack<Pair>(from[i]);
}

/// The same with the number of digits that the keys need.
template <class Key, class Pair>
void sort_bucket(const std::uint64_t* found, std::size_t n, const ShortKeys& short_keys,
                 Key* scratch, Pair* out) {
  if (short_keys.bits <= 2 * kDigitBits)
    sort_bucket<2>(found, n, short_keys, scratch, out);
  else if (short_keys.bits <= 3 * kDigitBits)
    sort_bucket<3>(found, n, short_keys, scratch, out);
  else if (short_keys.bits <= 4 * kDigitBits)
    sort_bucket<4>(found, n, short_keys, scratch, out);
  else if constexpr (sizeof(Key) > 4)  // Two indices of 31 bits, the first less 7 in common.
    sort_bucket<7>(found, n, short_keys, scratch, out);
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
  const int second_bits = static_cast<int>(std::bit_width(seconds));
  const ShortKeys all_keys{0, second_bits, second_bits + shift};
  if (all_keys.bits <= 32 ? short_scratch_.size() < 2 * total : long_scratch_.size() < 2 * total) {
    if (all_keys.bits <= 32)
      short_scratch_.resize(2 * total);
    else
      long_scratch_.resize(2 * total);
  }
  parallel_for(buckets, 1, [&](std::size_t begin, std::size_t end) {
    ShortKeys keys = all_keys;
    for (std::size_t b = begin; b < end; ++b) {
      const std::size_t first = bucket_begin[b], n = bucket_begin[b + 1] - first;
      keys.base = static_cast<std::uint32_t>(b << shift);
      if (keys.bits <= 32)
        sort_bucket(scratch_.data() + first, n, keys, short_scratch_.data() + 2 * first,
                    out.data() + first);
      else
        sort_bucket(scratch_.data() + first, n, keys, long_scratch_.data() + 2 * first,
                    out.data() + first);
    }
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

}  // namespace selvedge::detail
