// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/bounding_volume_tree.h>
#include <selvedge/core/parallel.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace selvedge::detail {
namespace {

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();
// Coordinates are clamped to a million kilometres so that areas stay finite in float.
constexpr double kFar = 1e12;
// One stretched triangle makes the areas of its ancestors meaningless; beyond this ratio a node
// counts as merely bad.
constexpr double kMaxRatio = 4.0;
constexpr int kBins = 16;
// A split that leaves less than this part of the items on one side is lopsided; a path down the
// tree may have kLopsidedSplits of them (to peel off far outliers), then it splits at the median,
// so that building takes O(n (log n + kLopsidedSplits)) whatever the input.
constexpr std::int32_t kLopsidedPart = 16;
constexpr int kLopsidedSplits = 12;
constexpr std::int32_t kSubtreeItems = 4096;  // built by one thread

constexpr FloatBox kEmptyBox{
    {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
     std::numeric_limits<float>::infinity(), 0.0f},
    {-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
     -std::numeric_limits<float>::infinity(), 0.0f}};

float to_float(double relative) {
  return static_cast<float>(std::min(std::max(relative, -kFar), kFar));
}

void grow(FloatBox& box, const FloatBox& other) {
  for (int k = 0; k < 4; ++k) {
    box.lo[k] = std::min(box.lo[k], other.lo[k]);
    box.hi[k] = std::max(box.hi[k], other.hi[k]);
  }
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

void BoundingVolumeTree::box_vertices(const SurfaceView& surface, const Vec3& origin) {
  vertex_boxes_.resize(vertex_count_);
  const double thickness = surface.thickness;
  parallel_for(vertex_count_, 8192, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const double* x0 = surface.x_t0[v].data();
      const double* x1 = surface.x_t1[v].data();
      FloatBox& box = vertex_boxes_[v];
      for (int k = 0; k < 3; ++k) {
        box.lo[k] = to_float((std::min(x0[k], x1[k]) - thickness) - origin[k]);
        box.hi[k] = to_float((std::max(x0[k], x1[k]) + thickness) - origin[k]);
      }
      box.lo[3] = box.hi[3] = 0.0f;
    }
  });
}

void BoundingVolumeTree::box_items() {
  const std::size_t triangles = topology_triangles_.size();
  items_.resize(triangles + loose_edges_.size() + loose_points_.size());
  parallel_for(items_.size(), 8192, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      FloatBox box;
      if (i < triangles) {
        const Triangle& t = topology_triangles_[i];
        box = vertex_boxes_[t[0]];
        grow(box, vertex_boxes_[t[1]]);
        grow(box, vertex_boxes_[t[2]]);
      } else if (i < triangles + loose_edges_.size()) {
        const Edge& e = topology_edges_[loose_edges_[i - triangles]];
        box = vertex_boxes_[e[0]];
        grow(box, vertex_boxes_[e[1]]);
      } else {
        box = vertex_boxes_[loose_points_[i - triangles - loose_edges_.size()]];
      }
      items_[i] = {{box.lo[0], box.lo[1], box.lo[2]},
                   static_cast<std::int32_t>(i),
                   {box.hi[0], box.hi[1], box.hi[2]},
                   0};
    }
  });
}

/// Nodes and leaves of a part of the tree; leaf indices and child nodes count from its own start.
struct BoundingVolumeTree::Subtree {
  std::vector<TreeNode> nodes;
  std::vector<Range> leaves;
};

/// Splits the items in place. [Wald2007] with bins on the longest axis of the centroids only.
struct BoundingVolumeTree::Builder {
  struct Part {
    Range range;
    FloatBox box;
    int lopsided = 0;  ///< lopsided splits above it
    std::int32_t size() const { return range.end - range.begin; }
  };
  /// A part that is left for another thread, and where its root is to be entered.
  struct Deferred {
    Part part;
    std::int32_t node;
    int lane;
  };

  std::vector<Item>& items;

  static FloatBox box_of(const Item& item) {
    return {{item.lo[0], item.lo[1], item.lo[2], 0.0f}, {item.hi[0], item.hi[1], item.hi[2], 0.0f}};
  }
  static float centroid(const Item& item, int axis) { return item.lo[axis] + item.hi[axis]; }

  Part make_part(Range range, int lopsided) const {
    Part part{range, kEmptyBox, lopsided};
    for (std::int32_t i = range.begin; i < range.end; ++i) grow(part.box, box_of(items[i]));
    return part;
  }

  /// Longest axis of the box around the centroids, its lower end and its length.
  struct Axis {
    int index;
    float lo, length;
  };
  Axis longest_axis(Range range) const {
    FloatBox box = kEmptyBox;
    for (std::int32_t i = range.begin; i < range.end; ++i) {
      FloatBox center;
      for (int k = 0; k < 3; ++k) center.lo[k] = center.hi[k] = centroid(items[i], k);
      center.lo[3] = center.hi[3] = 0.0f;
      grow(box, center);
    }
    Axis best{0, box.lo[0], box.hi[0] - box.lo[0]};
    for (int k = 1; k < 3; ++k)
      if (box.hi[k] - box.lo[k] > best.length) best = {k, box.lo[k], box.hi[k] - box.lo[k]};
    return best;
  }

  struct Bin {
    FloatBox box = kEmptyBox;
    std::int32_t count = 0;
  };

  /// The bin after which to split for the least Σ area·blocks, or -1 if all fall into one.
  static int best_split(const std::array<Bin, kBins>& bins) {
    std::array<float, kBins> right_cost{};
    Bin right;
    for (int b = kBins - 1; b > 0; --b) {
      grow(right.box, bins[b].box);
      right.count += bins[b].count;
      right_cost[b] =
          right.count ? half_area(right.box) * static_cast<float>(blocks_for(right.count)) : 0.0f;
    }
    const std::int32_t total = right.count + bins[0].count;
    int best = -1;
    float best_cost = std::numeric_limits<float>::infinity();
    std::int32_t best_imbalance = total;
    Bin left;
    for (int b = 0; b + 1 < kBins; ++b) {
      grow(left.box, bins[b].box);
      left.count += bins[b].count;
      if (left.count == 0 || left.count == total) continue;
      const float cost =
          half_area(left.box) * static_cast<float>(blocks_for(left.count)) + right_cost[b + 1];
      const std::int32_t imbalance = std::abs(2 * left.count - total);
      if (cost < best_cost || (cost == best_cost && imbalance < best_imbalance)) {
        best = b;
        best_cost = cost;
        best_imbalance = imbalance;
      }
    }
    return best;
  }

  /// Splits at the median centroid; ties go by index, so the result is always the same.
  std::int32_t split_median(Range range, int axis) {
    const std::int32_t middle =
        range.begin + kLanes * std::max(1, (range.end - range.begin) / (2 * kLanes));
    std::nth_element(items.begin() + range.begin, items.begin() + middle, items.begin() + range.end,
                     [axis](const Item& a, const Item& b) {
                       const float ca = centroid(a, axis), cb = centroid(b, axis);
                       return ca < cb || (ca == cb && a.index < b.index);
                     });
    return middle;
  }

  std::array<Part, 2> split(const Part& part) {
    const Range range = part.range;
    const Axis axis = longest_axis(range);
    // Below this length the reciprocal would overflow; such items are as good as in one point.
    constexpr float kShortest = 1e-30f;
    std::int32_t middle = 0;
    FloatBox left_box = kEmptyBox, right_box = kEmptyBox;
    int lopsided = part.lopsided;
    int cut = -1;
    if (axis.length > kShortest) {
      const float scale = static_cast<float>(kBins) / axis.length;
      const auto bin_of = [&](const Item& item) {
        const int b = static_cast<int>((centroid(item, axis.index) - axis.lo) * scale);
        return std::min(b, kBins - 1);
      };
      std::array<Bin, kBins> bins;
      for (std::int32_t i = range.begin; i < range.end; ++i) {
        Bin& bin = bins[bin_of(items[i])];
        grow(bin.box, box_of(items[i]));
        ++bin.count;
      }
      cut = best_split(bins);
      if (cut >= 0) {
        std::int32_t left = 0;
        for (int b = 0; b < kBins; ++b) {
          grow(b <= cut ? left_box : right_box, bins[b].box);
          if (b <= cut) left += bins[b].count;
        }
        const std::int32_t smaller = std::min(left, part.size() - left);
        if (smaller < part.size() / kLopsidedPart) ++lopsided;
        if (lopsided > kLopsidedSplits)
          cut = -1;
        else
          middle = static_cast<std::int32_t>(
              std::partition(items.begin() + range.begin, items.begin() + range.end,
                             [&](const Item& item) { return bin_of(item) <= cut; }) -
              items.begin());
      }
    }
    if (cut >= 0)
      return {Part{{range.begin, middle}, left_box, lopsided},
              Part{{middle, range.end}, right_box, lopsided}};
    middle = split_median(range, axis.index);
    return {make_part({range.begin, middle}, part.lopsided),
            make_part({middle, range.end}, part.lopsided)};
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

void BoundingVolumeTree::build(const SurfaceView& surface, const Vec3& origin) {
  box_vertices(surface, origin);
  box_items();
  nodes_.clear();
  leaf_items_.clear();
  Builder builder{items_};
  const Builder::Part all = builder.make_part({0, static_cast<std::int32_t>(items_.size())}, 0);
  if (all.size() > kLanes) {
    Subtree top;
    std::vector<Builder::Deferred> deferred;
    builder.build(all, top, &deferred, kSubtreeItems);
    std::vector<Subtree> below(deferred.size());
    parallel_for(below.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        builder.build(deferred[i].part, below[i], nullptr, 0);
    });
    nodes_ = std::move(top.nodes);
    leaf_items_ = std::move(top.leaves);
    for (std::size_t i = 0; i < below.size(); ++i) {
      const auto first_node = static_cast<std::int32_t>(nodes_.size());
      const auto first_leaf = static_cast<std::int32_t>(leaf_items_.size());
      nodes_[deferred[i].node].child[deferred[i].lane] = first_node;
      for (TreeNode& node : below[i].nodes)
        for (std::int32_t& child : node.child)
          if (child != kNoChild) child = child >= 0 ? child + first_node : ~(~child + first_leaf);
      nodes_.insert(nodes_.end(), below[i].nodes.begin(), below[i].nodes.end());
      leaf_items_.insert(leaf_items_.end(), below[i].leaves.begin(), below[i].leaves.end());
    }
  } else if (all.size() > 0) {
    leaf_items_.push_back(all.range);
  }
  lay_out_leaves();
  fit_leaves();
  fit_nodes();
  built_ratio_ = measure_looseness();
  looseness_ = 1.0;
}

void BoundingVolumeTree::refit(const SurfaceView& surface, const Vec3& origin) {
  box_vertices(surface, origin);
  fit_leaves();
  fit_nodes();
  looseness_ = measure_looseness() / built_ratio_;
}

/// Reserves the blocks of every leaf and writes the indices, which stay until the next build.
void BoundingVolumeTree::lay_out_leaves() {
  const auto triangles = static_cast<std::int32_t>(topology_triangles_.size());
  const auto edges = static_cast<std::int32_t>(loose_edges_.size());
  const auto owned = [](const std::vector<std::uint32_t>& begin, std::int32_t t) {
    return static_cast<std::int32_t>(begin[t + 1] - begin[t]);
  };
  leaves_.resize(leaf_items_.size());
  std::uint32_t point_blocks = 0, edge_blocks = 0, triangle_blocks = 0;
  for (std::size_t l = 0; l < leaves_.size(); ++l) {
    std::int32_t n_points = 0, n_edges = 0, n_triangles = 0;
    for (std::int32_t i = leaf_items_[l].begin; i < leaf_items_[l].end; ++i) {
      const std::int32_t item = items_[i].index;
      if (item < triangles) {
        ++n_triangles;
        n_edges += owned(owned_edges_begin_, item);
        n_points += owned(owned_points_begin_, item);
      } else {
        ++(item < triangles + edges ? n_edges : n_points);
      }
    }
    const std::int32_t pb = blocks_for(n_points), eb = blocks_for(n_edges),
                       tb = blocks_for(n_triangles);
    leaves_[l] = {kEmptyBox,
                  point_blocks,
                  edge_blocks,
                  triangle_blocks,
                  static_cast<std::uint8_t>(pb),
                  static_cast<std::uint8_t>(eb),
                  static_cast<std::uint8_t>(tb),
                  static_cast<std::uint8_t>(n_points),
                  static_cast<std::uint8_t>(n_edges),
                  static_cast<std::uint8_t>(n_triangles)};
    point_blocks += static_cast<std::uint32_t>(pb);
    edge_blocks += static_cast<std::uint32_t>(eb);
    triangle_blocks += static_cast<std::uint32_t>(tb);
  }
  points_.resize(point_blocks);
  edges_.resize(edge_blocks);
  triangles_.resize(triangle_blocks);
  parallel_for(leaves_.size(), 512, [&](std::size_t begin, std::size_t end) {
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
        const std::int32_t item = items_[i].index;
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

FloatBox BoundingVolumeTree::fit_points(const TreeLeaf& leaf) {
  FloatBox all = kEmptyBox;
  for (int i = 0; i < leaf.points; ++i) {
    PointBlock& block = points_[leaf.point_block + i / kLanes];
    const int lane = i % kLanes;
    const FloatBox& box = vertex_boxes_[block.id[lane]];
    set_lane(block.boxes, lane, box);
    grow(all, box);
  }
  return all;
}

FloatBox BoundingVolumeTree::fit_edges(const TreeLeaf& leaf) {
  FloatBox all = kEmptyBox;
  for (int i = 0; i < leaf.edges; ++i) {
    EdgeBlock& block = edges_[leaf.edge_block + i / kLanes];
    const int lane = i % kLanes;
    FloatBox box = vertex_boxes_[block.v0[lane]];
    grow(box, vertex_boxes_[block.v1[lane]]);
    set_lane(block.boxes, lane, box);
    grow(all, box);
  }
  return all;
}

FloatBox BoundingVolumeTree::fit_triangles(const TreeLeaf& leaf) {
  FloatBox all = kEmptyBox;
  for (int i = 0; i < leaf.triangles; ++i) {
    TriangleBlock& block = triangles_[leaf.triangle_block + i / kLanes];
    const int lane = i % kLanes;
    FloatBox box = vertex_boxes_[block.v0[lane]];
    grow(box, vertex_boxes_[block.v1[lane]]);
    grow(box, vertex_boxes_[block.v2[lane]]);
    set_lane(block.boxes, lane, box);
    grow(all, box);
  }
  return all;
}

void BoundingVolumeTree::fit_leaves() {
  parallel_for(leaves_.size(), 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t l = begin; l < end; ++l) {
      TreeLeaf& leaf = leaves_[l];
      leaf.box = fit_triangles(leaf);
      grow(leaf.box, fit_edges(leaf));
      grow(leaf.box, fit_points(leaf));
    }
  });
}

void BoundingVolumeTree::fit_nodes() {
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    TreeNode& node = nodes_[n];
    for (int lane = 0; lane < kLanes && node.child[lane] != kNoChild; ++lane) {
      const std::int32_t child = node.child[lane];
      if (child < 0) {
        set_lane(node.boxes, lane, leaves_[~child].box);
        continue;
      }
      FloatBox box = kEmptyBox;
      const TreeNode& below = nodes_[child];
      for (int k = 0; k < kLanes && below.child[k] != kNoChild; ++k)
        grow(box, lane_box(below.boxes, k));
      set_lane(node.boxes, lane, box);
    }
  }
}

double BoundingVolumeTree::measure_looseness() const {
  double sum = 0.0;
  for (const TreeNode& node : nodes_) {
    double children = 0.0;
    FloatBox all = kEmptyBox;
    for (int lane = 0; lane < kLanes && node.child[lane] != kNoChild; ++lane) {
      const FloatBox box = lane_box(node.boxes, lane);
      children += half_area(box);
      grow(all, box);
    }
    // Children that overlap add up to more than their union.
    const double own = half_area(all);
    sum += own > 0.0 ? std::min(children / own, kMaxRatio) : 1.0;
  }
  return nodes_.empty() ? 1.0 : std::max(sum / static_cast<double>(nodes_.size()), 1e-3);
}

std::size_t BoundingVolumeTree::bytes() const {
  return bytes_of(topology_triangles_) + bytes_of(topology_edges_) + bytes_of(loose_edges_) +
         bytes_of(loose_points_) + bytes_of(owned_edges_begin_) + bytes_of(owned_points_begin_) +
         bytes_of(owned_edges_) + bytes_of(owned_points_) + bytes_of(nodes_) + bytes_of(leaves_) +
         bytes_of(leaf_items_) + bytes_of(points_) + bytes_of(edges_) + bytes_of(triangles_) +
         bytes_of(vertex_boxes_) + bytes_of(items_);
}

}  // namespace selvedge::detail
