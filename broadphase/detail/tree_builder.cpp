// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/tree_builder.h>
#include <selvedge/core/base/parallel.h>

#include <cmath>

namespace selvedge::detail {
namespace {

using Range = TreeSkeleton::Range;
using Node = TreeSkeleton::Node;

constexpr int kBins = 16;
// With few items, fewer bins find the same cut in less time.
constexpr int kFewBins = 8;
constexpr std::int32_t kFewItems = 64;
// A split that leaves less than 1/kLopsidedPart of the items on one side is lopsided. A path down
// the tree may have kLopsidedSplits of them (to separate far outliers); then it splits at the
// median, so that building takes O(n (log n + kLopsidedSplits)) for any input.
constexpr std::int32_t kLopsidedPart = 16;
constexpr int kLopsidedSplits = 12;
constexpr std::int32_t kSubtreeLeaves = 256;  // minimum number of leaves that one task builds
constexpr std::size_t kItemGrain = 1024;      // items per task

constexpr FloatBox kEmptyBox = empty_dop<3>();

/// Nodes and leaves of a part of the tree; leaf indices and child nodes are relative to its own
/// start.
struct Subtree {
  std::vector<Node> nodes;
  std::vector<Range> leaves;
  std::int32_t parent = 0;  ///< node and lane above its root
  int lane = 0;
};

/// Splits the items in place.
struct Builder {
  struct Part {
    Range range;
    FloatBox box = kEmptyBox;
    FloatBox centroids = kEmptyBox;  ///< doubled: lower plus upper corners
    int lopsided = 0;                ///< number of lopsided splits above it
    std::int32_t size() const { return range.end - range.begin; }
  };
  /// A part that is left for another thread, and the place where its root is entered.
  struct Deferred {
    Part part;
    std::int32_t node;
    int lane;
  };
  struct Bin {
    FloatBox box = kEmptyBox, centroids = kEmptyBox;
    std::int32_t count = 0;

    void add(const Bin& other) {
      grow(box, other.box);
      grow(centroids, other.centroids);
      count += other.count;
    }
    void add(const FloatBox& item) {
      grow(box, item);
      grow(centroids, centroid_box(item));
      ++count;
    }
  };
  using Bins = std::array<Bin, kBins>;

  /// Maps an item of `part` to its bin.
  struct Binning {
    int axis;
    float lo, scale;
    int last;

    int operator()(const FloatBox& item) const {
      return std::min(static_cast<int>((centroid(item, axis) - lo) * scale), last);
    }
  };

  TreeShape shape;
  std::vector<FloatBox>& items;
  std::vector<FloatBox>& scratch;

  static float centroid(const FloatBox& item, int axis) { return item.lo[axis] + item.hi[axis]; }
  static FloatBox centroid_box(const FloatBox& item) {
    FloatBox box;
#ifdef __SSE2__
    // The index in the fourth lane must not be added as a float: it would be denormal.
    const __m128 three = _mm_castsi128_ps(_mm_set_epi32(0, -1, -1, -1));
    const __m128 lo = _mm_and_ps(three, _mm_load_ps(item.lo.data()));
    const __m128 sum = _mm_add_ps(lo, _mm_load_ps(item.hi.data()));
    _mm_store_ps(box.lo.data(), sum);
    _mm_store_ps(box.hi.data(), sum);
#else
    for (int k = 0; k < 3; ++k) box.lo[k] = box.hi[k] = item.lo[k] + item.hi[k];
    box.lo[3] = box.hi[3] = 0.0f;
#endif
    return box;
  }

  /// Calls body(chunk, part of the range) for chunks of the range that do not depend on the number
  /// of threads; a short range is one chunk.
  template <class Body>
  static void each_chunk(Range range, Body body) {
    parallel_for(range.end - range.begin, kItemGrain, [&](std::size_t begin, std::size_t end) {
      body(begin / kItemGrain, Range{range.begin + static_cast<std::int32_t>(begin),
                                     range.begin + static_cast<std::int32_t>(end)});
    });
  }
  static std::size_t chunks_of(Range range) {
    return (static_cast<std::size_t>(range.end - range.begin) + kItemGrain - 1) / kItemGrain;
  }

  Part make_part(Range range, int lopsided) const {
    std::vector<Bin> chunks(chunks_of(range));
    each_chunk(range, [&](std::size_t chunk, Range part) {
      Bin sum;
      for (std::int32_t i = part.begin; i < part.end; ++i) sum.add(items[i]);
      chunks[chunk] = sum;
    });
    Bin all;
    for (const Bin& chunk : chunks) all.add(chunk);
    return {range, all.box, all.centroids, lopsided};
  }

  static int longest_axis(const FloatBox& box) {
    int best = 0;
    for (int k = 1; k < 3; ++k)
      if (box.hi[k] - box.lo[k] > box.hi[best] - box.lo[best]) best = k;
    return best;
  }

  Bins fill_bins(Range range, const Binning& bin_of) const {
    if (chunks_of(range) <= 1) return fill_bins_alone(range, bin_of);
    std::vector<Bins> chunks(chunks_of(range));
    each_chunk(range, [&](std::size_t chunk, Range part) {
      chunks[chunk] = fill_bins_alone(part, bin_of);
    });
    for (std::size_t c = 1; c < chunks.size(); ++c)
      for (int b = 0; b <= bin_of.last; ++b) chunks[0][b].add(chunks[c][b]);
    return chunks[0];
  }

  Bins fill_bins_alone(Range range, const Binning& bin_of) const {
    // Two alternating sets, so that the next item does not wait for a bin's last store.
    std::array<Bins, 2> sets;
    for (std::int32_t i = range.begin; i < range.end; ++i)
      sets[i & 1][bin_of(items[i])].add(items[i]);
    for (int b = 0; b <= bin_of.last; ++b) sets[0][b].add(sets[1][b]);
    return sets[0];
  }

  float cost(const Bin& side) const {
    if (side.count == 0) return 0.0f;
    const std::int32_t leaves = (side.count + shape.leaf_size - 1) / shape.leaf_size;
    return half_area(side.box) * static_cast<float>(leaves);
  }

  struct Split {
    Bin left, right;
    int last_left;  ///< the last bin that goes left, or -1
  };

  /// The cut with the least Σ area·leaves; among equals the most balanced.
  Split best_split(const Bins& bins, int last) const {
    Bins from_right;
    Bin side;
    for (int b = last; b >= 0; --b) {
      side.add(bins[b]);
      from_right[b] = side;
    }
    const std::int32_t total = side.count;
    Split best{{}, {}, -1};
    float best_cost = std::numeric_limits<float>::infinity();
    std::int32_t best_imbalance = total;
    side = {};
    for (int b = 0; b < last; ++b) {
      side.add(bins[b]);
      if (side.count == 0 || side.count == total) continue;
      const float here = cost(side) + cost(from_right[b + 1]);
      const std::int32_t imbalance = std::abs(2 * side.count - total);
      if (here < best_cost || (here == best_cost && imbalance < best_imbalance)) {
        best = {side, from_right[b + 1], b};
        best_cost = here;
        best_imbalance = imbalance;
      }
    }
    return best;
  }

  /// Moves the items of the first bins to the front, keeping their order.
  void partition(Range range, const Binning& bin_of, int last_left, std::int32_t left_count) {
    if (chunks_of(range) <= 1)
      partition_alone(range, bin_of, last_left);
    else
      partition_by_chunks(range, bin_of, last_left, left_count);
  }

  /// Branch-free version for one thread.
  void partition_alone(Range range, const Binning& bin_of, int last_left) {
    FloatBox* left = items.data() + range.begin;
    FloatBox* right = scratch.data() + range.begin;
    for (std::int32_t i = range.begin; i < range.end; ++i) {
      const FloatBox item = items[i];
      const bool goes_left = bin_of(item) <= last_left;
      *left = *right = item;
      left += goes_left;
      right += !goes_left;
    }
    std::copy(scratch.data() + range.begin, right, left);
  }

  void partition_by_chunks(Range range, const Binning& bin_of, int last_left,
                           std::int32_t left_count) {
    std::vector<std::int32_t> left_before(chunks_of(range) + 1, 0);
    each_chunk(range, [&](std::size_t chunk, Range part) {
      std::int32_t count = 0;
      for (std::int32_t i = part.begin; i < part.end; ++i) count += bin_of(items[i]) <= last_left;
      left_before[chunk + 1] = count;
    });
    for (std::size_t c = 1; c < left_before.size(); ++c) left_before[c] += left_before[c - 1];
    each_chunk(range, [&](std::size_t chunk, Range part) {
      const std::int32_t before = part.begin - range.begin;
      FloatBox* left = scratch.data() + range.begin + left_before[chunk];
      FloatBox* right = scratch.data() + range.begin + left_count + (before - left_before[chunk]);
      for (std::int32_t i = part.begin; i < part.end; ++i)
        (bin_of(items[i]) <= last_left ? *left++ : *right++) = items[i];
    });
    each_chunk(range, [&](std::size_t, Range part) {
      std::copy(scratch.data() + part.begin, scratch.data() + part.end, items.data() + part.begin);
    });
  }

  /// Splits at the median centroid; ties are ordered by index, so the result is deterministic.
  std::array<Part, 2> split_median(const Part& part) {
    const int axis = longest_axis(part.centroids);
    const Range range = part.range;
    const std::int32_t middle =
        range.begin + shape.leaf_size * std::max(1, part.size() / (2 * shape.leaf_size));
    std::nth_element(items.begin() + range.begin, items.begin() + middle, items.begin() + range.end,
                     [axis](const FloatBox& a, const FloatBox& b) {
                       const float ca = centroid(a, axis), cb = centroid(b, axis);
                       return ca < cb || (ca == cb && item_index(a) < item_index(b));
                     });
    return {make_part({range.begin, middle}, part.lopsided),
            make_part({middle, range.end}, part.lopsided)};
  }

  std::array<Part, 2> split(const Part& part) {
    const int axis = longest_axis(part.centroids);
    const float length = part.centroids.hi[axis] - part.centroids.lo[axis];
    // Below this length the reciprocal would overflow; such items practically coincide.
    constexpr float kShortest = 1e-30f;
    if (!(length > kShortest)) return split_median(part);
    const int bins = part.size() < kFewItems ? kFewBins : kBins;
    const Binning bin_of{axis, part.centroids.lo[axis], static_cast<float>(bins) / length,
                         bins - 1};
    const Split best = best_split(fill_bins(part.range, bin_of), bin_of.last);
    const std::int32_t smaller = std::min(best.left.count, best.right.count);
    const int lopsided = part.lopsided + (smaller < part.size() / kLopsidedPart);
    if (best.last_left < 0 || lopsided > kLopsidedSplits) return split_median(part);
    partition(part.range, bin_of, best.last_left, best.left.count);
    const std::int32_t middle = part.range.begin + best.left.count;
    return {Part{{part.range.begin, middle}, best.left.box, best.left.centroids, lopsided},
            Part{{middle, part.range.end}, best.right.box, best.right.centroids, lopsided}};
  }

  /// Splits the part with the largest area until there are `arity` parts or only leaves are left.
  int split_manifold(const Part& part, std::array<Part, kLanes>& parts) {
    int count = 1;
    parts[0] = part;
    while (count < shape.arity) {
      int widest = -1;
      float widest_area = -1.0f;
      for (int i = 0; i < count; ++i)
        if (parts[i].size() > shape.leaf_size && half_area(parts[i].box) > widest_area) {
          widest = i;
          widest_area = half_area(parts[i].box);
        }
      if (widest < 0) break;
      const std::array<Part, 2> halves = split(parts[widest]);
      parts[widest] = halves[0];
      parts[count++] = halves[1];
    }
    return count;
  }

  /// Builds below `part`, which has more items than a leaf holds. If `deferred` is given, leaves
  /// parts of at most `defer_below` items to the caller.
  void build(const Part& part, Subtree& out, std::vector<Deferred>* deferred,
             std::int32_t defer_below) {
    const auto node = static_cast<std::int32_t>(out.nodes.size());
    out.nodes.emplace_back();
    std::fill_n(out.nodes[node].child, kLanes, kNoChild);
    std::array<Part, kLanes> parts;
    const int count = split_manifold(part, parts);
    for (int lane = 0; lane < count; ++lane) {
      if (parts[lane].size() <= shape.leaf_size) {
        out.nodes[node].child[lane] = ~static_cast<std::int32_t>(out.leaves.size());
        out.leaves.push_back(parts[lane].range);
      } else if (deferred && parts[lane].size() <= defer_below) {
        deferred->push_back({parts[lane], node, lane});
      } else {
        out.nodes[node].child[lane] = static_cast<std::int32_t>(out.nodes.size());
        build(parts[lane], out, deferred, defer_below);
      }
    }
  }
};

/// Concatenates the parts of the tree.
void join(Subtree& top, const std::vector<Subtree>& below, TreeSkeleton& out) {
  std::size_t node = top.nodes.size(), leaf = top.leaves.size();
  out.subtree_begin.assign(1, node);
  std::vector<std::size_t> leaf_begin;
  for (const Subtree& part : below) {
    top.nodes[part.parent].child[part.lane] = static_cast<std::int32_t>(node);
    leaf_begin.push_back(leaf);
    node += part.nodes.size();
    leaf += part.leaves.size();
    out.subtree_begin.push_back(node);
  }
  out.nodes.resize(node);
  out.leaves.resize(leaf);
  std::copy(top.nodes.begin(), top.nodes.end(), out.nodes.begin());
  std::copy(top.leaves.begin(), top.leaves.end(), out.leaves.begin());
  parallel_for(below.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto first_node = static_cast<std::int32_t>(out.subtree_begin[i]);
      const auto first_leaf = static_cast<std::int32_t>(leaf_begin[i]);
      Node* to = out.nodes.data() + first_node;
      for (const Node& from : below[i].nodes) {
        *to = from;
        for (std::int32_t& child : (to++)->child)
          if (child != kNoChild) child = child >= 0 ? child + first_node : ~(~child + first_leaf);
      }
      std::copy(below[i].leaves.begin(), below[i].leaves.end(), out.leaves.begin() + first_leaf);
    }
  });
}

}  // namespace

void build_tree(const TreeShape& shape, std::vector<FloatBox>& items,
                std::vector<FloatBox>& scratch, TreeSkeleton& out) {
  out.nodes.clear();
  out.leaves.clear();
  out.subtree_begin.assign(1, 0);
  scratch.resize(items.size());
  Builder builder{shape, items, scratch};
  const Builder::Part all = builder.make_part({0, static_cast<std::int32_t>(items.size())}, 0);
  if (all.size() <= shape.leaf_size) {
    if (all.size() > 0) out.leaves.push_back(all.range);
    return;
  }
  Subtree top;
  std::vector<Builder::Deferred> deferred;
  builder.build(all, top, &deferred, kSubtreeLeaves * shape.leaf_size);
  std::vector<Subtree> below(deferred.size());
  parallel_for(below.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      below[i].parent = deferred[i].node;
      below[i].lane = deferred[i].lane;
      builder.build(deferred[i].part, below[i], nullptr, 0);
    }
  });
  join(top, below, out);
}

std::size_t TreeSkeleton::bytes() const {
  return nodes.capacity() * sizeof(Node) + leaves.capacity() * sizeof(Range) +
         subtree_begin.capacity() * sizeof(std::size_t);
}

}  // namespace selvedge::detail
