// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/bounding_volume_tree.h>
#include <selvedge/core/parallel.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace selvedge::detail {
namespace {

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();
// Coordinates are clamped to a million kilometres so that areas stay finite in float.
constexpr double kFar = 1e12;
// One stretched triangle makes the areas of its ancestors meaningless; beyond this ratio a node
// counts as merely bad.
constexpr double kMaxRatio = 4.0;
constexpr int kBins = 16;
// For few items fewer bins find the same cut in less time.
constexpr int kFewBins = 8;
constexpr std::int32_t kFewItems = 64;
// A split that leaves less than this part of the items on one side is lopsided; a path down the
// tree may have kLopsidedSplits of them (to peel off far outliers), then it splits at the median,
// so that building takes O(n (log n + kLopsidedSplits)) whatever the input.
constexpr std::int32_t kLopsidedPart = 16;
constexpr int kLopsidedSplits = 12;
constexpr std::int32_t kSubtreeItems = 4096;  // built by one thread
constexpr std::size_t kLeafGrain = 256;       // leaves that one thread lays out or fits
constexpr std::size_t kItemGrain = 4096;      // items of a range that one thread looks through

constexpr FloatBox kEmptyBox{
    {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
     std::numeric_limits<float>::infinity(), 0.0f},
    {-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
     -std::numeric_limits<float>::infinity(), 0.0f}};

float to_float(double relative) {
  return static_cast<float>(std::min(std::max(relative, -kFar), kFar));
}

void grow(FloatBox& box, const FloatBox& other) {
#ifdef __SSE2__
  _mm_store_ps(box.lo.data(), _mm_min_ps(_mm_load_ps(box.lo.data()), _mm_load_ps(other.lo.data())));
  _mm_store_ps(box.hi.data(), _mm_max_ps(_mm_load_ps(box.hi.data()), _mm_load_ps(other.hi.data())));
#else
  for (int k = 0; k < 3; ++k) {
    box.lo[k] = std::min(box.lo[k], other.lo[k]);
    box.hi[k] = std::max(box.hi[k], other.hi[k]);
  }
#endif
}

float half_area(const FloatBox& box) {
  const float x = box.hi[0] - box.lo[0], y = box.hi[1] - box.lo[1], z = box.hi[2] - box.lo[2];
  return x * y + y * z + z * x;
}

void set_lane(BoxBlock& block, int lane, const FloatBox& box) {
  for (int k = 0; k < 3; ++k) {
    block.lo[k][lane] = box.lo[k];
    block.hi[k][lane] = box.hi[k];
  }
}

void clear_lanes(BoxBlock& block) {
  for (int k = 0; k < 3; ++k)
    for (int lane = 0; lane < kLanes; ++lane) block.lo[k][lane] = block.hi[k][lane] = kNotANumber;
}

FloatBox lane_box(const BoxBlock& block, int lane) {
  return {{block.lo[0][lane], block.lo[1][lane], block.lo[2][lane], 0.0f},
          {block.hi[0][lane], block.hi[1][lane], block.hi[2][lane], 0.0f}};
}

std::int32_t blocks_for(std::int32_t lanes) { return (lanes + kLanes - 1) / kLanes; }

template <class T>
std::size_t bytes_of(const std::vector<T>& v) {
  return v.capacity() * sizeof(T);
}

template <class T>
bool same_bytes(std::span<const T> a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

/// Triangles around each vertex.
struct VertexTriangles {
  std::vector<std::uint32_t> begin;
  std::vector<std::int32_t> triangle;

  VertexTriangles(std::span<const Triangle> triangles, std::size_t n)
      : begin(n + 1, 0), triangle(3 * triangles.size()) {
    for (const Triangle& t : triangles)
      for (const std::int32_t v : t) ++begin[v + 1];
    for (std::size_t v = 0; v < n; ++v) begin[v + 1] += begin[v];
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (const std::int32_t v : triangles[t]) triangle[next[v]++] = static_cast<std::int32_t>(t);
  }
  std::span<const std::int32_t> of(std::int32_t v) const {
    return {triangle.data() + begin[v], begin[v + 1] - begin[v]};
  }
};

/// Groups 0..owner.size()-1 by owner; those with owner -1 go to `loose`.
void group_by_owner(const std::vector<std::int32_t>& owner, std::size_t owners,
                    std::vector<std::uint32_t>& begin, std::vector<std::int32_t>& owned,
                    std::vector<std::int32_t>& loose) {
  begin.assign(owners + 1, 0);
  loose.clear();
  for (const std::int32_t o : owner)
    if (o >= 0) ++begin[o + 1];
  for (std::size_t o = 0; o < owners; ++o) begin[o + 1] += begin[o];
  owned.resize(begin[owners]);
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (std::size_t i = 0; i < owner.size(); ++i)
    if (owner[i] >= 0)
      owned[next[owner[i]]++] = static_cast<std::int32_t>(i);
    else
      loose.push_back(static_cast<std::int32_t>(i));
}

/// The map m of FloatBox, on every vertex.
void box_vertices(const SurfaceView& surface, const Vec3& origin,
                  std::vector<FloatBox>& vertex_boxes) {
  const std::size_t n = surface.x_t0.size();
  vertex_boxes.resize(n);
  const double thickness = surface.thickness;
  parallel_for(n, 8192, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const double* x0 = surface.x_t0[v].data();
      const double* x1 = surface.x_t1[v].data();
      FloatBox& box = vertex_boxes[v];
      for (int k = 0; k < 3; ++k) {
        box.lo[k] = to_float((std::min(x0[k], x1[k]) - thickness) - origin[k]);
        box.hi[k] = to_float((std::max(x0[k], x1[k]) + thickness) - origin[k]);
      }
      box.lo[3] = box.hi[3] = 0.0f;
    }
  });
}

std::int32_t item_index(const FloatBox& item) { return std::bit_cast<std::int32_t>(item.lo[3]); }

}  // namespace

bool BoundingVolumeTree::has_topology_of(const SurfaceView& surface) const {
  return surface.x_t0.size() == vertex_count_ && same_bytes(surface.edges, topology_edges_) &&
         same_bytes(surface.triangles, topology_triangles_);
}

void BoundingVolumeTree::set_topology(const SurfaceView& surface) {
  vertex_count_ = surface.x_t0.size();
  topology_triangles_.assign(surface.triangles.begin(), surface.triangles.end());
  topology_edges_.assign(surface.edges.begin(), surface.edges.end());
  nodes_.clear();
  leaves_.clear();
  find_owners();
}

/// Of the triangles that contain it, the owner of an edge or a point is the one that owns least so
/// far: leaves of equal size then hold about the same number of edges and points.
void BoundingVolumeTree::find_owners() {
  const VertexTriangles around(topology_triangles_, vertex_count_);
  const std::size_t triangles = topology_triangles_.size();
  std::vector<std::uint16_t> load(triangles, 0);  // owned so far
  const auto take_least = [&](std::int32_t& best, std::int32_t t) {
    if (best < 0 || load[t] < load[best]) best = t;
  };

  std::vector<std::int32_t> owner(topology_edges_.size(), -1);
  for (std::size_t e = 0; e < owner.size(); ++e) {
    for (const std::int32_t t : around.of(topology_edges_[e][0])) {
      const Triangle& corners = topology_triangles_[t];
      if (std::find(corners.begin(), corners.end(), topology_edges_[e][1]) != corners.end())
        take_least(owner[e], t);
    }
    // A list with repeated edges must not overfill a leaf.
    if (owner[e] >= 0 && load[owner[e]] >= kMostOwned) owner[e] = -1;
    if (owner[e] >= 0) ++load[owner[e]];
  }
  group_by_owner(owner, triangles, owned_edges_begin_, owned_edges_, loose_edges_);

  std::fill(load.begin(), load.end(), std::uint16_t{0});
  owner.assign(vertex_count_, -1);
  for (std::size_t v = 0; v < vertex_count_; ++v) {
    for (const std::int32_t t : around.of(static_cast<std::int32_t>(v))) take_least(owner[v], t);
    if (owner[v] >= 0) ++load[owner[v]];
  }
  group_by_owner(owner, triangles, owned_points_begin_, owned_points_, loose_points_);
}

void BoundingVolumeTree::box_items(TreeScratch& scratch) const {
  const std::vector<FloatBox>& vertex_boxes = scratch.vertex_boxes;
  std::vector<FloatBox>& items = scratch.items;
  const std::size_t triangles = topology_triangles_.size();
  items.resize(triangles + loose_edges_.size() + loose_points_.size());
  parallel_for(items.size(), 8192, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      FloatBox box;
      if (i < triangles) {
        const Triangle& t = topology_triangles_[i];
        box = vertex_boxes[t[0]];
        grow(box, vertex_boxes[t[1]]);
        grow(box, vertex_boxes[t[2]]);
      } else if (i < triangles + loose_edges_.size()) {
        const Edge& e = topology_edges_[loose_edges_[i - triangles]];
        box = vertex_boxes[e[0]];
        grow(box, vertex_boxes[e[1]]);
      } else {
        box = vertex_boxes[loose_points_[i - triangles - loose_edges_.size()]];
      }
      box.lo[3] = std::bit_cast<float>(static_cast<std::int32_t>(i));
      items[i] = box;
    }
  });
}

/// Nodes and leaves of a part of the tree; leaf indices and child nodes count from its own start.
struct BoundingVolumeTree::Subtree {
  std::vector<TreeNode> nodes;
  std::vector<Range> leaves;
  std::int32_t parent = 0;  ///< the node and lane above its root
  int lane = 0;
};

/// Splits the items in place. [Wald2007] with bins on the longest axis of the centroids only.
struct BoundingVolumeTree::Builder {
  struct Part {
    Range range;
    FloatBox box = kEmptyBox;
    FloatBox centroids = kEmptyBox;  ///< doubled: lower plus upper corners
    int lopsided = 0;                ///< lopsided splits above it
    std::int32_t size() const { return range.end - range.begin; }
  };
  /// A part that is left for another thread, and where its root is to be entered.
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

  /// Which bin of `part` an item falls into.
  struct Binning {
    int axis;
    float lo, scale;
    int last;

    int operator()(const FloatBox& item) const {
      return std::min(static_cast<int>((centroid(item, axis) - lo) * scale), last);
    }
  };

  std::vector<FloatBox>& items;
  std::vector<FloatBox>& scratch;

  static float centroid(const FloatBox& item, int axis) { return item.lo[axis] + item.hi[axis]; }
  static FloatBox centroid_box(const FloatBox& item) {
    FloatBox box;
#ifdef __SSE2__
    // The index in the fourth lane must not be added as if it were a number: it would be denormal.
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
    // Two sets in turn, so that a bin's last store is not waited for.
    std::array<Bins, 2> sets;
    for (std::int32_t i = range.begin; i < range.end; ++i)
      sets[i & 1][bin_of(items[i])].add(items[i]);
    for (int b = 0; b <= bin_of.last; ++b) sets[0][b].add(sets[1][b]);
    return sets[0];
  }

  static float cost(const Bin& side) {
    return side.count ? half_area(side.box) * static_cast<float>(blocks_for(side.count)) : 0.0f;
  }

  struct Split {
    Bin left, right;
    int last_left;  ///< the last bin that goes left, or -1
  };

  /// The cut with the least Σ area·blocks, among equals the most balanced.
  static Split best_split(const Bins& bins, int last) {
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

  /// Brings the items of the first bins to the front, keeping their order.
  void partition(Range range, const Binning& bin_of, int last_left, std::int32_t left_count) {
    if (chunks_of(range) <= 1)
      partition_alone(range, bin_of, last_left);
    else
      partition_by_chunks(range, bin_of, last_left, left_count);
  }

  /// Without branches.
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

  /// Splits at the median centroid; ties go by index, so the result is always the same.
  std::array<Part, 2> split_median(const Part& part) {
    const int axis = longest_axis(part.centroids);
    const Range range = part.range;
    const std::int32_t middle = range.begin + kLanes * std::max(1, part.size() / (2 * kLanes));
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
    // Below this length the reciprocal would overflow; such items are as good as in one point.
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

  /// Splits the part with the largest area until there are eight or only leaves are left.
  int split_eightfold(const Part& part, std::array<Part, kLanes>& parts) {
    int count = 1;
    parts[0] = part;
    while (count < kLanes) {
      int widest = -1;
      float widest_area = -1.0f;
      for (int i = 0; i < count; ++i)
        if (parts[i].size() > kLanes && half_area(parts[i].box) > widest_area) {
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

  /// Builds below `part`, which has more items than a leaf holds; leaves parts of at most
  /// `defer_below` items to the caller when `deferred` is given.
  void build(const Part& part, Subtree& out, std::vector<Deferred>* deferred,
             std::int32_t defer_below) {
    const auto node = static_cast<std::int32_t>(out.nodes.size());
    out.nodes.emplace_back();
    clear_lanes(out.nodes[node].boxes);
    std::fill_n(out.nodes[node].child, kLanes, kNoChild);
    std::array<Part, kLanes> parts;
    const int count = split_eightfold(part, parts);
    for (int lane = 0; lane < count; ++lane) {
      if (parts[lane].size() <= kLanes) {
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

void BoundingVolumeTree::build(const SurfaceView& surface, const Vec3& origin,
                               TreeScratch& scratch) {
  box_vertices(surface, origin, scratch.vertex_boxes);
  box_items(scratch);
  split_items(scratch);
  lay_out_leaves(scratch.items);
  fit_leaves(scratch.vertex_boxes);
  fit_nodes();
  built_ratio_ = measure_looseness();
  looseness_ = 1.0;
  ++version_;
}

void BoundingVolumeTree::split_items(TreeScratch& scratch) {
  nodes_.clear();
  leaf_items_.clear();
  subtree_begin_.assign(1, 0);
  scratch.partitioned.resize(scratch.items.size());
  Builder builder{scratch.items, scratch.partitioned};
  const Builder::Part all =
      builder.make_part({0, static_cast<std::int32_t>(scratch.items.size())}, 0);
  if (all.size() > kLanes) {
    Subtree top;
    std::vector<Builder::Deferred> deferred;
    builder.build(all, top, &deferred, kSubtreeItems);
    std::vector<Subtree> below(deferred.size());
    parallel_for(below.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        below[i].parent = deferred[i].node;
        below[i].lane = deferred[i].lane;
        builder.build(deferred[i].part, below[i], nullptr, 0);
      }
    });
    join(top, below);
  } else if (all.size() > 0) {
    leaf_items_.push_back(all.range);
  }
}

/// Puts the parts of the tree one behind the other.
void BoundingVolumeTree::join(Subtree& top, const std::vector<Subtree>& below) {
  std::size_t node = top.nodes.size(), leaf = top.leaves.size();
  subtree_begin_.assign(1, node);
  std::vector<std::size_t> leaf_begin;
  for (std::size_t i = 0; i < below.size(); ++i) {
    top.nodes[below[i].parent].child[below[i].lane] = static_cast<std::int32_t>(node);
    leaf_begin.push_back(leaf);
    node += below[i].nodes.size();
    leaf += below[i].leaves.size();
    subtree_begin_.push_back(node);
  }
  nodes_.resize(node);
  leaf_items_.resize(leaf);
  std::copy(top.nodes.begin(), top.nodes.end(), nodes_.begin());
  std::copy(top.leaves.begin(), top.leaves.end(), leaf_items_.begin());
  parallel_for(below.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto first_node = static_cast<std::int32_t>(subtree_begin_[i]);
      const auto first_leaf = static_cast<std::int32_t>(leaf_begin[i]);
      TreeNode* out = nodes_.data() + first_node;
      for (const TreeNode& node : below[i].nodes) {
        *out = node;
        for (std::int32_t& child : (out++)->child)
          if (child != kNoChild) child = child >= 0 ? child + first_node : ~(~child + first_leaf);
      }
      std::copy(below[i].leaves.begin(), below[i].leaves.end(), leaf_items_.begin() + first_leaf);
    }
  });
}

void BoundingVolumeTree::refit(const SurfaceView& surface, const Vec3& origin,
                               TreeScratch& scratch) {
  box_vertices(surface, origin, scratch.vertex_boxes);
  fit_leaves(scratch.vertex_boxes);
  fit_nodes();
  looseness_ = measure_looseness() / built_ratio_;
}

/// Reserves the blocks of every leaf and writes the indices, which stay until the next build.
void BoundingVolumeTree::lay_out_leaves(const std::vector<FloatBox>& items) {
  const auto triangles = static_cast<std::int32_t>(topology_triangles_.size());
  const auto edges = static_cast<std::int32_t>(loose_edges_.size());
  const auto owned = [](const std::vector<std::uint32_t>& begin, std::int32_t t) {
    return static_cast<std::int32_t>(begin[t + 1] - begin[t]);
  };
  leaves_.resize(leaf_items_.size());
  parallel_for(leaves_.size(), kLeafGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t l = begin; l < end; ++l) {
      std::int32_t n_points = 0, n_edges = 0, n_triangles = 0;
      for (std::int32_t i = leaf_items_[l].begin; i < leaf_items_[l].end; ++i) {
        const std::int32_t item = item_index(items[i]);
        if (item < triangles) {
          ++n_triangles;
          n_edges += owned(owned_edges_begin_, item);
          n_points += owned(owned_points_begin_, item);
        } else {
          ++(item < triangles + edges ? n_edges : n_points);
        }
      }
      leaves_[l] = {kEmptyBox,
                    0,
                    0,
                    0,
                    static_cast<std::uint8_t>(blocks_for(n_points)),
                    static_cast<std::uint8_t>(blocks_for(n_edges)),
                    static_cast<std::uint8_t>(blocks_for(n_triangles)),
                    static_cast<std::uint8_t>(n_points),
                    static_cast<std::uint8_t>(n_edges),
                    static_cast<std::uint8_t>(n_triangles)};
    }
  });
  std::uint32_t point_blocks = 0, edge_blocks = 0, triangle_blocks = 0;
  for (TreeLeaf& leaf : leaves_) {
    leaf.point_block = std::exchange(point_blocks, point_blocks + leaf.point_blocks);
    leaf.edge_block = std::exchange(edge_blocks, edge_blocks + leaf.edge_blocks);
    leaf.triangle_block = std::exchange(triangle_blocks, triangle_blocks + leaf.triangle_blocks);
  }
  points_.resize(point_blocks);
  edges_.resize(edge_blocks);
  triangles_.resize(triangle_blocks);
  parallel_for(leaves_.size(), kLeafGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t l = begin; l < end; ++l) {
      const TreeLeaf& leaf = leaves_[l];
      int n_points = 0, n_edges = 0, n_triangles = 0;
      for (int b = 0; b < leaf.point_blocks; ++b) {
        PointBlock& block = points_[leaf.point_block + b];
        clear_lanes(block.boxes);
        std::fill_n(block.id, kLanes, -1);
      }
      for (int b = 0; b < leaf.edge_blocks; ++b) {
        EdgeBlock& block = edges_[leaf.edge_block + b];
        clear_lanes(block.boxes);
        for (std::int32_t* ids : {block.id, block.v0, block.v1}) std::fill_n(ids, kLanes, -1);
      }
      for (int b = 0; b < leaf.triangle_blocks; ++b) {
        TriangleBlock& block = triangles_[leaf.triangle_block + b];
        clear_lanes(block.boxes);
        for (std::int32_t* ids : {block.id, block.v0, block.v1, block.v2})
          std::fill_n(ids, kLanes, -1);
      }
      const auto add_point = [&](std::int32_t v) {
        points_[leaf.point_block + n_points / kLanes].id[n_points % kLanes] = v;
        ++n_points;
      };
      const auto add_edge = [&](std::int32_t e) {
        EdgeBlock& block = edges_[leaf.edge_block + n_edges / kLanes];
        block.id[n_edges % kLanes] = e;
        block.v0[n_edges % kLanes] = topology_edges_[e][0];
        block.v1[n_edges % kLanes] = topology_edges_[e][1];
        ++n_edges;
      };
      for (std::int32_t i = leaf_items_[l].begin; i < leaf_items_[l].end; ++i) {
        const std::int32_t item = item_index(items[i]);
        if (item < triangles) {
          TriangleBlock& block = triangles_[leaf.triangle_block + n_triangles / kLanes];
          const int lane = n_triangles++ % kLanes;
          block.id[lane] = item;
          block.v0[lane] = topology_triangles_[item][0];
          block.v1[lane] = topology_triangles_[item][1];
          block.v2[lane] = topology_triangles_[item][2];
          for (std::uint32_t k = owned_edges_begin_[item]; k < owned_edges_begin_[item + 1]; ++k)
            add_edge(owned_edges_[k]);
          for (std::uint32_t k = owned_points_begin_[item]; k < owned_points_begin_[item + 1]; ++k)
            add_point(owned_points_[k]);
        } else if (item < triangles + edges) {
          add_edge(loose_edges_[item - triangles]);
        } else {
          add_point(loose_points_[item - triangles - edges]);
        }
      }
    }
  });
}

FloatBox BoundingVolumeTree::fit_points(const TreeLeaf& leaf,
                                        const std::vector<FloatBox>& vertex_boxes) {
  FloatBox all = kEmptyBox;
  for (int i = 0; i < leaf.points; ++i) {
    PointBlock& block = points_[leaf.point_block + i / kLanes];
    const int lane = i % kLanes;
    const FloatBox& box = vertex_boxes[block.id[lane]];
    set_lane(block.boxes, lane, box);
    grow(all, box);
  }
  return all;
}

FloatBox BoundingVolumeTree::fit_edges(const TreeLeaf& leaf,
                                       const std::vector<FloatBox>& vertex_boxes) {
  FloatBox all = kEmptyBox;
  for (int i = 0; i < leaf.edges; ++i) {
    EdgeBlock& block = edges_[leaf.edge_block + i / kLanes];
    const int lane = i % kLanes;
    FloatBox box = vertex_boxes[block.v0[lane]];
    grow(box, vertex_boxes[block.v1[lane]]);
    set_lane(block.boxes, lane, box);
    grow(all, box);
  }
  return all;
}

FloatBox BoundingVolumeTree::fit_triangles(const TreeLeaf& leaf,
                                           const std::vector<FloatBox>& vertex_boxes) {
  FloatBox all = kEmptyBox;
  for (int i = 0; i < leaf.triangles; ++i) {
    TriangleBlock& block = triangles_[leaf.triangle_block + i / kLanes];
    const int lane = i % kLanes;
    FloatBox box = vertex_boxes[block.v0[lane]];
    grow(box, vertex_boxes[block.v1[lane]]);
    grow(box, vertex_boxes[block.v2[lane]]);
    set_lane(block.boxes, lane, box);
    grow(all, box);
  }
  return all;
}

void BoundingVolumeTree::fit_leaves(const std::vector<FloatBox>& vertex_boxes) {
  parallel_for(leaves_.size(), kLeafGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t l = begin; l < end; ++l) {
      TreeLeaf& leaf = leaves_[l];
      leaf.box = fit_triangles(leaf, vertex_boxes);
      grow(leaf.box, fit_edges(leaf, vertex_boxes));
      grow(leaf.box, fit_points(leaf, vertex_boxes));
    }
  });
}

void BoundingVolumeTree::fit_nodes() {
  const std::size_t subtrees = subtree_begin_.size() - 1;
  parallel_for(subtrees, 1, [&](std::size_t begin, std::size_t end) {
    fit_nodes(subtree_begin_[begin], subtree_begin_[end]);
  });
  fit_nodes(0, subtree_begin_[0]);
}

/// The children of these nodes that are not among them must have been fitted.
void BoundingVolumeTree::fit_nodes(std::size_t begin, std::size_t end) {
  for (std::size_t n = end; n-- > begin;) {
    TreeNode& node = nodes_[n];
    node.box = kEmptyBox;
    for (int lane = 0; lane < kLanes && node.child[lane] != kNoChild; ++lane) {
      const std::int32_t child = node.child[lane];
      const FloatBox& below = child < 0 ? leaves_[~child].box : nodes_[child].box;
      set_lane(node.boxes, lane, below);
      grow(node.box, below);
    }
  }
}

double BoundingVolumeTree::measure_looseness() const {
  constexpr std::size_t grain = 512;
  const double sum = parallel_sum(nodes_.size(), grain, [&](std::size_t begin, std::size_t end) {
    double part = 0.0;
    for (std::size_t n = begin; n < end; ++n) part += overlap_ratio(nodes_[n]);
    return part;
  });
  return nodes_.empty() ? 1.0 : std::max(sum / static_cast<double>(nodes_.size()), 1e-3);
}

/// Children that overlap add up to more than their union.
double BoundingVolumeTree::overlap_ratio(const TreeNode& node) {
  double children = 0.0;
  for (int lane = 0; lane < kLanes && node.child[lane] != kNoChild; ++lane)
    children += half_area(lane_box(node.boxes, lane));
  const double own = half_area(node.box);
  return own > 0.0 ? std::min(children / own, kMaxRatio) : 1.0;
}

std::size_t BoundingVolumeTree::bytes() const {
  return bytes_of(topology_triangles_) + bytes_of(topology_edges_) + bytes_of(loose_edges_) +
         bytes_of(loose_points_) + bytes_of(owned_edges_begin_) + bytes_of(owned_points_begin_) +
         bytes_of(owned_edges_) + bytes_of(owned_points_) + bytes_of(nodes_) + bytes_of(leaves_) +
         bytes_of(leaf_items_) + bytes_of(subtree_begin_) + bytes_of(points_) + bytes_of(edges_) +
         bytes_of(triangles_);
}

}  // namespace selvedge::detail
