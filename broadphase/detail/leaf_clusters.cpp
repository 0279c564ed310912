// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/leaf_clusters.h>

#include <utility>

namespace selvedge::detail {
namespace {

/// Additional rounds after the last doubling, in which remaining groups are merged.
constexpr int kMoreRounds = 3;

using SharedSide = std::array<std::int32_t, 2>;

/// Groups under construction. Each round merges pairs of them.
class Matching {
 public:
  Matching(std::span<const SharedSide> sides, std::size_t triangles, int most)
      : most_(most), size_(triangles, 1), group_(triangles) {
    sides_.reserve(sides.size());
    for (const SharedSide& s : sides)
      if (s[1] >= 0) sides_.push_back(s);
    for (std::size_t t = 0; t < triangles; ++t) group_[t] = static_cast<std::int32_t>(t);
    keep_open_sides();
  }

  /// Merges one round; returns the number of merged pairs.
  std::size_t merge() {
    list_neighbours();
    const std::size_t n = size_.size();
    partner_.assign(n, kNone);
    weight_.assign(n, 0);
    std::size_t merged = 0;
    for (std::size_t g = 0; g < n; ++g) {
      const auto group = static_cast<std::int32_t>(g);
      if (partner_[group] != kNone) continue;
      const std::int32_t best = heaviest_free_neighbour(group);
      if (best == kNone) continue;
      partner_[group] = best;
      partner_[best] = group;
      ++merged;
    }
    if (merged > 0) renumber();
    return merged;
  }

  const std::vector<std::int32_t>& group() const { return group_; }
  std::size_t count() const { return size_.size(); }

 private:
  static constexpr std::int32_t kNone = -1;

  /// Drops the sides inside a group and between groups that together are too large.
  void keep_open_sides() {
    std::erase_if(sides_, [&](const SharedSide& s) {
      return s[0] == s[1] || size_[s[0]] + size_[s[1]] > most_;
    });
  }

  void list_neighbours() {
    begin_.assign(size_.size() + 2, 0);
    for (const SharedSide& s : sides_) {
      ++begin_[s[0] + 2];
      ++begin_[s[1] + 2];
    }
    for (std::size_t g = 2; g < begin_.size(); ++g) begin_[g] += begin_[g - 1];
    neighbour_.resize(2 * sides_.size());
    for (const SharedSide& s : sides_) {
      neighbour_[begin_[s[0] + 1]++] = s[1];
      neighbour_[begin_[s[1] + 1]++] = s[0];
    }
  }

  /// The unmatched neighbour with the most common sides; among equals the first.
  std::int32_t heaviest_free_neighbour(std::int32_t group) {
    std::int32_t best = kNone;
    for (std::uint32_t k = begin_[group]; k < begin_[group + 1]; ++k) {
      const std::int32_t other = neighbour_[k];
      if (partner_[other] != kNone) continue;
      ++weight_[other];
      if (best == kNone || weight_[other] > weight_[best] ||
          (weight_[other] == weight_[best] && other < best))
        best = other;
    }
    for (std::uint32_t k = begin_[group]; k < begin_[group + 1]; ++k) weight_[neighbour_[k]] = 0;
    return best;
  }

  void renumber() {
    std::vector<std::int32_t>& name = weight_;
    std::int32_t next = 0;
    for (std::size_t g = 0; g < size_.size(); ++g) {
      const std::int32_t other = partner_[g];
      const bool second = other != kNone && other < static_cast<std::int32_t>(g);
      name[g] = second ? name[other] : next;
      if (second)
        size_[name[other]] += size_[g];
      else
        size_[next++] = size_[g];
    }
    size_.resize(static_cast<std::size_t>(next));
    for (std::int32_t& g : group_) g = name[g];
    for (SharedSide& s : sides_) s = {name[s[0]], name[s[1]]};
    keep_open_sides();
  }

  int most_;
  std::vector<SharedSide> sides_;
  std::vector<std::int32_t> size_, group_, partner_, weight_, neighbour_;
  std::vector<std::uint32_t> begin_;
};

}  // namespace

LeafClusters cluster_triangles(const OwnedPrimitives& primitives, int most) {
  Matching matching(primitives.sides(), primitives.triangles.size(), most);
  int rounds = kMoreRounds;
  for (int size = 1; size < most; size *= 2) ++rounds;
  while (rounds-- > 0 && matching.merge() > 0) {
  }
  LeafClusters out;
  out.group = matching.group();
  out.begin.assign(matching.count() + 1, 0);
  for (const std::int32_t g : out.group) ++out.begin[g + 1];
  for (std::size_t g = 0; g < matching.count(); ++g) out.begin[g + 1] += out.begin[g];
  out.triangles.resize(out.group.size());
  std::vector<std::int32_t> next(out.begin.begin(), out.begin.end() - 1);
  for (std::size_t t = 0; t < out.group.size(); ++t)
    out.triangles[next[out.group[t]]++] = static_cast<std::int32_t>(t);
  return out;
}

}  // namespace selvedge::detail
