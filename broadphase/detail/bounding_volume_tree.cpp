// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/bounding_volume_tree.h>
#include <selvedge/broadphase/detail/bytes.h>
#include <selvedge/core/base/parallel.h>

#include <algorithm>
#include <utility>

namespace selvedge::detail {
namespace {

// One stretched triangle makes the areas of its ancestors meaningless, so the ratio of a node is
// limited to this value.
constexpr double kMaxRatio = 4.0;
constexpr std::size_t kVertexGrain = 2048;  // vertices or items per task of boxing
constexpr std::size_t kLeafGrain = 256;     // leaves per task of layout
constexpr std::size_t kFitGrain = 64;       // leaves per task of fitting: 10 µs of work
// Leaves by topology are used if they are at most this many times as many as full leaves would be.
constexpr std::size_t kMostLeaves = 2;
constexpr std::size_t kOrientGrain = 16;  // nodes per task of finding oriented boxes

std::uint8_t blocks_for(int lanes) {
  return static_cast<std::uint8_t>((lanes + kLanes - 1) / kLanes);
}

template <class Leaf>
void set_block_counts(Leaf& leaf) {
  leaf.point_blocks = blocks_for(leaf.points);
  leaf.edge_blocks = blocks_for(leaf.edges);
  leaf.triangle_blocks = blocks_for(leaf.triangles);
}

template <int axes>
FloatBox box_of(const FloatDop<axes>& dop) {
  return {{dop.lo[0], dop.lo[1], dop.lo[2], 0.0f}, {dop.hi[0], dop.hi[1], dop.hi[2], 0.0f}};
}

}  // namespace

template <BoundingVolume V>
void VolumeTree<V>::set_topology(const SurfaceView& surface) {
  primitives_.set(surface);
  nodes_.clear();
  leaves_.clear();
  grouped_ = lay_out_groups(surface);
  if (!grouped_) primitives_.find_owners();
}

/// Makes leaves of connected triangles if these fill the leaves well. A soup of triangles has none,
/// and its leaves are found anew in each build.
template <BoundingVolume V>
bool VolumeTree<V>::lay_out_groups(const SurfaceView& surface) {
  if (surface.triangles.empty()) return false;
  const LeafGroups groups(surface, shape_.leaf_size);
  const std::size_t most =
      kMostLeaves * surface.triangles.size() / static_cast<std::size_t>(shape_.leaf_size) + 1;
  const std::size_t loose = groups.loose_edges().size() + groups.loose_points().size();
  if (groups.count() + loose > most) return false;
  primitives_.set_loose(groups.loose_edges(), groups.loose_points());
  leaves_.resize(groups.count() + loose);
  count_groups(groups);
  place_blocks();
  fill_groups(groups);
  add_loose_leaves(groups);
  if constexpr (V::oriented) list_leaf_vertices();
  return true;
}

template <BoundingVolume V>
void VolumeTree<V>::count_groups(const LeafGroups& groups) {
  parallel_for(groups.chunk_count(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      for (std::int32_t g = groups.first_group(c); g < groups.end_group(c); ++g) leaves_[g] = {};
      groups.each_triangle(c, [&](std::int32_t, std::int32_t g) { ++leaves_[g].triangles; });
      groups.each_edge(c, [&](std::int32_t, std::int32_t g) { ++leaves_[g].edges; });
      groups.each_point(c, [&](std::int32_t, std::int32_t g) { ++leaves_[g].points; });
      for (std::int32_t g = groups.first_group(c); g < groups.end_group(c); ++g)
        set_block_counts(leaves_[g]);
    }
  });
  const std::size_t edges = groups.count() + groups.loose_edges().size();
  for (std::size_t l = groups.count(); l < leaves_.size(); ++l) {
    leaves_[l] = {};
    leaves_[l].loose = true;
    (l < edges ? leaves_[l].edges : leaves_[l].points) = 1;
    set_block_counts(leaves_[l]);
  }
}

/// Sorts the primitives of each chunk by leaf first, so that the blocks are written in order.
template <BoundingVolume V>
void VolumeTree<V>::fill_groups(const LeafGroups& groups) {
  parallel_for(groups.chunk_count(), 1, [&](std::size_t begin, std::size_t end) {
    std::vector<std::int32_t> order;
    std::vector<std::uint32_t> next;
    for (std::size_t c = begin; c < end; ++c) {
      const std::int32_t first = groups.first_group(c), last = groups.end_group(c);
      const auto fill = [&](std::uint8_t Leaf::*count, auto each, auto set) {
        next.clear();
        std::uint32_t sum = 0;
        for (std::int32_t g = first; g < last; ++g)
          next.push_back(std::exchange(sum, sum + leaves_[g].*count));
        order.resize(sum);
        each([&](std::int32_t id, std::int32_t g) { order[next[g - first]++] = id; });
        const std::int32_t* id = order.data();
        for (std::int32_t g = first; g < last; ++g)
          for (int lane = 0; lane < leaves_[g].*count; ++lane) set(leaves_[g], lane, *id++);
      };
      fill(
          &Leaf::triangles, [&](auto visit) { groups.each_triangle(c, visit); },
          [&](const Leaf& leaf, int lane, std::int32_t t) { set_triangle(leaf, lane, t); });
      fill(
          &Leaf::edges, [&](auto visit) { groups.each_edge(c, visit); },
          [&](const Leaf& leaf, int lane, std::int32_t e) { set_edge(leaf, lane, e); });
      fill(
          &Leaf::points, [&](auto visit) { groups.each_point(c, visit); },
          [&](const Leaf& leaf, int lane, std::int32_t v) { set_point(leaf, lane, v); });
      for (std::int32_t g = first; g < last; ++g) clear_unused(leaves_[g]);
    }
  });
}

template <BoundingVolume V>
void VolumeTree<V>::add_loose_leaves(const LeafGroups& groups) {
  std::size_t l = groups.count();
  for (const std::int32_t e : groups.loose_edges()) set_edge(leaves_[l++], 0, e);
  for (const std::int32_t v : groups.loose_points()) set_point(leaves_[l++], 0, v);
  for (l = groups.count(); l < leaves_.size(); ++l) clear_unused(leaves_[l]);
}

template <BoundingVolume V>
void VolumeTree<V>::build(const SurfaceView& surface, const TreePlace& place, Scratch& scratch) {
  box_vertices(surface, place, scratch);
  if (grouped_)
    build_over_leaves(scratch);
  else
    build_over_items(scratch);
  fit_nodes();
  if constexpr (V::oriented) orient(surface, place, scratch);
  built_ratio_ = measure_overlap();
  quality_loss_ = 1.0;
  ++version_;
}

template <BoundingVolume V>
void VolumeTree<V>::build_over_leaves(Scratch& scratch) {
  fit_leaves(scratch.vertex_boxes);
  scratch.items.resize(leaves_.size());
  for (std::size_t l = 0; l < leaves_.size(); ++l) {
    scratch.items[l] = box_of(leaves_[l].box);
    scratch.items[l].lo[3] = Eigen::numext::bit_cast<float>(static_cast<std::int32_t>(l));
  }
  build_tree({shape_.arity, 1}, scratch.items, scratch.partitioned, scratch.skeleton);
  for (auto& node : scratch.skeleton.nodes)
    for (std::int32_t& child : node.child)
      if (child < 0 && child != kNoChild)
        child = ~item_index(scratch.items[scratch.skeleton.leaves[~child].begin]);
  take_nodes(scratch.skeleton);
}

template <BoundingVolume V>
void VolumeTree<V>::build_over_items(Scratch& scratch) {
  box_items(scratch);
  build_tree(shape_, scratch.items, scratch.partitioned, scratch.skeleton);
  take_nodes(scratch.skeleton);
  scratch.item_order.resize(scratch.items.size());
  std::transform(scratch.items.begin(), scratch.items.end(), scratch.item_order.begin(),
                 item_index);
  lay_out_leaves(scratch.item_order, scratch.skeleton.leaves);
  fit_leaves(scratch.vertex_boxes);
}

template <BoundingVolume V>
void VolumeTree<V>::refit(const SurfaceView& surface, const TreePlace& place, Scratch& scratch) {
  box_vertices(surface, place, scratch);
  fit(surface, place, scratch);
  quality_loss_ = measure_overlap() / built_ratio_;
}

template <BoundingVolume V>
void VolumeTree<V>::fit(const SurfaceView& surface, const TreePlace& place, Scratch& scratch) {
  fit_leaves(scratch.vertex_boxes);
  fit_nodes();
  if constexpr (V::oriented) orient(surface, place, scratch);
}

/// Applies the map m of FloatDop to every vertex.
template <BoundingVolume V>
void VolumeTree<V>::box_vertices(const SurfaceView& surface, const TreePlace& place,
                                 Scratch& scratch) const {
  std::vector<Dop>& boxes = scratch.vertex_boxes;
  boxes.resize(surface.x_t0.size());
  const auto origin = along_directions<kAxes>(place.origin);
  parallel_for(boxes.size(), kVertexGrain, [&](std::size_t begin, std::size_t end) {
    if (place.maps) {
      for (std::size_t v = begin; v < end; ++v)
        boxes[v] = to_float(
            swept_dop<kAxes>(detail::path_of(surface, static_cast<std::int32_t>(v))), place.maps);
      return;
    }
    if (!place.frame) {  // The test is outside the loop for speed.
      for (std::size_t v = begin; v < end; ++v)
        if constexpr (kAxes == 3)
          boxes[v] = float_box(surface, static_cast<std::int32_t>(v), origin);
        else
          boxes[v] = to_float(
              swept_dop<kAxes>(detail::path_of(surface, static_cast<std::int32_t>(v))), origin);
      return;
    }
    for (std::size_t v = begin; v < end; ++v)
      boxes[v] =
          to_float(swept_dop<kAxes>(place.path_of(surface, static_cast<std::int32_t>(v))), origin);
  });
}

template <BoundingVolume V>
void VolumeTree<V>::box_items(Scratch& scratch) const {
  const std::vector<Dop>& vertex_boxes = scratch.vertex_boxes;
  const OwnedPrimitives& p = primitives_;
  std::vector<FloatBox>& items = scratch.items;
  items.resize(p.item_count());
  parallel_for(items.size(), kVertexGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      FloatBox box;
      const auto take = [&](const auto& vertices) {
        box = box_of(vertex_boxes[vertices[0]]);
        for (std::size_t k = 1; k < vertices.size(); ++k)
          grow(box, box_of(vertex_boxes[vertices[k]]));
      };
      if (i < p.triangles.size())
        take(p.triangles[i]);
      else if (i < p.triangles.size() + p.loose_edges.size())
        take(p.edges[p.loose_edges[i - p.triangles.size()]]);
      else
        take(std::array{p.loose_points[i - p.triangles.size() - p.loose_edges.size()]});
      box.lo[3] = Eigen::numext::bit_cast<float>(static_cast<std::int32_t>(i));
      items[i] = box;
    }
  });
}

template <BoundingVolume V>
void VolumeTree<V>::take_nodes(const TreeSkeleton& skeleton) {
  subtree_begin_ = skeleton.subtree_begin;
  nodes_.resize(skeleton.nodes.size());
  parallel_for(nodes_.size(), kLeafGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      clear_lanes(nodes_[n].boxes);
      std::copy_n(skeleton.nodes[n].child, kLanes, nodes_[n].child);
    }
  });
}

/// Reserves the blocks of every leaf and writes the indices, which stay valid until the next build.
template <BoundingVolume V>
void VolumeTree<V>::lay_out_leaves(std::span<const std::int32_t> items,
                                   std::span<const Range> ranges) {
  const auto of = [&](std::size_t l) {
    return items.subspan(static_cast<std::size_t>(ranges[l].begin),
                         static_cast<std::size_t>(ranges[l].end - ranges[l].begin));
  };
  leaves_.resize(ranges.size());
  parallel_for(leaves_.size(), kLeafGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t l = begin; l < end; ++l) count_leaf(leaves_[l], of(l));
  });
  place_blocks();
  parallel_for(leaves_.size(), kLeafGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t l = begin; l < end; ++l) fill_leaf(leaves_[l], of(l));
  });
  if constexpr (V::oriented) list_leaf_vertices();
}

template <BoundingVolume V>
void VolumeTree<V>::count_leaf(Leaf& leaf, std::span<const std::int32_t> items) const {
  const OwnedPrimitives& p = primitives_;
  const auto triangles = static_cast<std::int32_t>(p.triangles.size());
  const auto edges = static_cast<std::int32_t>(p.loose_edges.size());
  const auto owned = [](const std::vector<std::uint32_t>& begin, std::int32_t t) {
    return static_cast<std::int32_t>(begin[t + 1] - begin[t]);
  };
  std::int32_t n_points = 0, n_edges = 0, n_triangles = 0;
  leaf.loose = false;
  for (const std::int32_t item : items) {
    if (item < triangles) {
      ++n_triangles;
      n_edges += owned(p.owned_edges_begin, item);
      n_points += owned(p.owned_points_begin, item);
    } else {
      leaf.loose = true;
      ++(item < triangles + edges ? n_edges : n_points);
    }
  }
  leaf.points = static_cast<std::uint8_t>(n_points);
  leaf.edges = static_cast<std::uint8_t>(n_edges);
  leaf.triangles = static_cast<std::uint8_t>(n_triangles);
  set_block_counts(leaf);
}

template <BoundingVolume V>
void VolumeTree<V>::place_blocks() {
  std::uint32_t point_blocks = 0, edge_blocks = 0, triangle_blocks = 0;
  for (Leaf& leaf : leaves_) {
    leaf.point_block = std::exchange(point_blocks, point_blocks + leaf.point_blocks);
    leaf.edge_block = std::exchange(edge_blocks, edge_blocks + leaf.edge_blocks);
    leaf.triangle_block = std::exchange(triangle_blocks, triangle_blocks + leaf.triangle_blocks);
  }
  points_.reset(point_blocks);
  edges_.reset(edge_blocks);
  triangles_.reset(triangle_blocks);
}

template <BoundingVolume V>
void VolumeTree<V>::set_point(const Leaf& leaf, int lane, std::int32_t v) {
  points_[leaf.point_block + lane / kLanes].id[lane % kLanes] = v;
}

template <BoundingVolume V>
void VolumeTree<V>::set_edge(const Leaf& leaf, int lane, std::int32_t e) {
  auto& block = edges_[leaf.edge_block + lane / kLanes];
  block.id[lane % kLanes] = e;
  block.v0[lane % kLanes] = primitives_.edges[e][0];
  block.v1[lane % kLanes] = primitives_.edges[e][1];
}

template <BoundingVolume V>
void VolumeTree<V>::set_triangle(const Leaf& leaf, int lane, std::int32_t t) {
  auto& block = triangles_[leaf.triangle_block + lane / kLanes];
  block.id[lane % kLanes] = t;
  block.v0[lane % kLanes] = primitives_.triangles[t][0];
  block.v1[lane % kLanes] = primitives_.triangles[t][1];
  block.v2[lane % kLanes] = primitives_.triangles[t][2];
}

/// Marks the lanes after the last primitive of each kind.
template <BoundingVolume V>
void VolumeTree<V>::clear_unused(const Leaf& leaf) {
  const auto clear = [](auto& block, int used, auto... ids) {
    clear_lanes(block.boxes);
    (std::fill(ids + used, ids + kLanes, -1), ...);
  };
  if (const int used = leaf.points % kLanes; used > 0) {
    auto& block = points_[leaf.point_block + leaf.point_blocks - 1];
    clear(block, used, block.id);
  }
  if (const int used = leaf.edges % kLanes; used > 0) {
    auto& block = edges_[leaf.edge_block + leaf.edge_blocks - 1];
    clear(block, used, block.id, block.v0, block.v1);
  }
  if (const int used = leaf.triangles % kLanes; used > 0) {
    auto& block = triangles_[leaf.triangle_block + leaf.triangle_blocks - 1];
    clear(block, used, block.id, block.v0, block.v1, block.v2);
  }
}

template <BoundingVolume V>
void VolumeTree<V>::fill_leaf(const Leaf& leaf, std::span<const std::int32_t> items) {
  const OwnedPrimitives& p = primitives_;
  const auto triangles = static_cast<std::int32_t>(p.triangles.size());
  const auto edges = static_cast<std::int32_t>(p.loose_edges.size());
  int n_points = 0, n_edges = 0, n_triangles = 0;
  for (const std::int32_t item : items) {
    if (item < triangles) {
      set_triangle(leaf, n_triangles++, item);
      for (std::uint32_t k = p.owned_edges_begin[item]; k < p.owned_edges_begin[item + 1]; ++k)
        set_edge(leaf, n_edges++, p.owned_edges[k]);
      for (std::uint32_t k = p.owned_points_begin[item]; k < p.owned_points_begin[item + 1]; ++k)
        set_point(leaf, n_points++, p.owned_points[k]);
    } else if (item < triangles + edges) {
      set_edge(leaf, n_edges++, p.loose_edges[item - triangles]);
    } else {
      set_point(leaf, n_points++, p.loose_points[item - triangles - edges]);
    }
  }
  clear_unused(leaf);
}

/// Collects the vertices of each leaf.
template <BoundingVolume V>
void VolumeTree<V>::list_leaf_vertices() {
  leaf_vertices_begin_.assign(1, 0);
  leaf_vertices_.clear();
  for (const Leaf& leaf : leaves_) {
    const std::size_t first = leaf_vertices_.size();
    for (int i = 0; i < leaf.triangles; ++i) {
      const auto& block = triangles(leaf)[i / kLanes];
      for (const std::int32_t* v : {block.v0, block.v1, block.v2})
        leaf_vertices_.push_back(v[i % kLanes]);
    }
    for (int i = 0; i < leaf.edges; ++i) {
      const auto& block = edges(leaf)[i / kLanes];
      for (const std::int32_t* v : {block.v0, block.v1}) leaf_vertices_.push_back(v[i % kLanes]);
    }
    for (int i = 0; i < leaf.points; ++i)
      leaf_vertices_.push_back(points(leaf)[i / kLanes].id[i % kLanes]);
    const auto begin = leaf_vertices_.begin() + static_cast<std::ptrdiff_t>(first);
    std::sort(begin, leaf_vertices_.end());
    leaf_vertices_.erase(std::unique(begin, leaf_vertices_.end()), leaf_vertices_.end());
    leaf_vertices_begin_.push_back(static_cast<std::uint32_t>(leaf_vertices_.size()));
  }
}

/// Fits the blocks of a leaf, `count` lanes in all, by box(block, lane), and passes each box to
/// `visit`.
template <class Block, class Box, class Visit>
void fit_blocks(Block* block, int count, Box box, Visit visit) {
  for (; count > 0; ++block, count -= kLanes)
    set_lanes(block->boxes, std::min(count, kLanes), [&](int lane) {
      const auto fitted = box(*block, lane);
      visit(fitted);
      return fitted;
    });
}

/// Owned points and edges lie in the boxes of their triangles.
template <BoundingVolume V>
void VolumeTree<V>::fit_leaf(Leaf& leaf, const std::vector<Dop>& vertex_boxes) {
  leaf.box = empty_dop<kAxes>();
  const auto widen = [&](const Dop& box) { grow(leaf.box, box); };
  const auto widen_by_loose = [&](const Dop& box) {
    if (leaf.loose) grow(leaf.box, box);
  };
  const auto of_triangle = [&](const auto& block, int lane) {
    Dop box = vertex_boxes[block.v0[lane]];
    grow(box, vertex_boxes[block.v1[lane]]);
    grow(box, vertex_boxes[block.v2[lane]]);
    return box;
  };
  const auto of_edge = [&](const auto& block, int lane) {
    Dop box = vertex_boxes[block.v0[lane]];
    grow(box, vertex_boxes[block.v1[lane]]);
    return box;
  };
  const auto of_point = [&](const auto& block, int lane) { return vertex_boxes[block.id[lane]]; };
  fit_blocks(triangles_.data() + leaf.triangle_block, leaf.triangles, of_triangle, widen);
  fit_blocks(edges_.data() + leaf.edge_block, leaf.edges, of_edge, widen_by_loose);
  fit_blocks(points_.data() + leaf.point_block, leaf.points, of_point, widen_by_loose);
}

template <BoundingVolume V>
void VolumeTree<V>::fit_leaves(const std::vector<Dop>& vertex_boxes) {
  parallel_for(leaves_.size(), kFitGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t l = begin; l < end; ++l) fit_leaf(leaves_[l], vertex_boxes);
  });
}

template <BoundingVolume V>
void VolumeTree<V>::fit_nodes() {
  const std::size_t subtrees = subtree_begin_.size() - 1;
  parallel_for(subtrees, 1, [&](std::size_t begin, std::size_t end) {
    fit_nodes(subtree_begin_[begin], subtree_begin_[end]);
  });
  fit_nodes(0, subtree_begin_[0]);
}

/// Children of these nodes that are not among them must already be fitted.
template <BoundingVolume V>
void VolumeTree<V>::fit_nodes(std::size_t begin, std::size_t end) {
  for (std::size_t n = end; n-- > begin;) {
    Node& node = nodes_[n];
    node.box = empty_dop<kAxes>();
    const auto children = std::find(node.child, node.child + kLanes, kNoChild) - node.child;
    set_lanes(node.boxes, static_cast<int>(children), [&](int lane) {
      const std::int32_t child = node.child[lane];
      const Dop& below = child < 0 ? leaves_[~child].box : nodes_[child].box;
      grow(node.box, below);
      return below;
    });
  }
}

/// Oriented boxes around the vertices below each node and leaf.
template <BoundingVolume V>
void VolumeTree<V>::orient(const SurfaceView& surface, const TreePlace& place, Scratch& scratch) {
  if constexpr (V::oriented) {
    const auto each_vertex = [&](std::int32_t leaf, auto visit) {
      for (std::uint32_t i = leaf_vertices_begin_[leaf]; i < leaf_vertices_begin_[leaf + 1]; ++i)
        visit(place.path_of(surface, leaf_vertices_[i]));
    };
    const auto moments_of = [&](std::int32_t leaf) {
      Moments moments;
      each_vertex(leaf, [&](const VertexPath& path) {
        moments.add(path.y_t0 - place.origin);
        moments.add(path.y_t1 - place.origin);
      });
      return moments;
    };
    std::vector<Moments> leaf_moments(leaves_.size());
    parallel_for(leaves_.size(), kLeafGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t l = begin; l < end; ++l) {
        const auto leaf = static_cast<std::int32_t>(l);
        leaf_moments[l] = moments_of(leaf);
        ObbFit obb(leaf_moments[l], place.origin);
        each_vertex(leaf, [&](const VertexPath& path) { obb.add(path); });
        leaves_[l].obb = obb.result();
      }
    });
    std::vector<Moments>& node_moments = scratch.node_moments;
    node_moments.assign(nodes_.size(), {});
    for (std::size_t n = nodes_.size(); n-- > 0;)
      for (int lane = 0; lane < kLanes && nodes_[n].child[lane] != kNoChild; ++lane) {
        const std::int32_t child = nodes_[n].child[lane];
        node_moments[n].add(child < 0 ? leaf_moments[~child] : node_moments[child]);
      }
    parallel_for(nodes_.size(), kOrientGrain, [&](std::size_t begin, std::size_t end) {
      std::vector<std::int32_t> below;
      for (std::size_t n = begin; n < end; ++n) {
        ObbFit obb(node_moments[n], place.origin);
        below.assign(1, static_cast<std::int32_t>(n));
        while (!below.empty()) {
          const Node& node = nodes_[below.back()];
          below.pop_back();
          for (int lane = 0; lane < kLanes && node.child[lane] != kNoChild; ++lane)
            if (node.child[lane] < 0)
              each_vertex(~node.child[lane], [&](const VertexPath& path) { obb.add(path); });
            else
              below.push_back(node.child[lane]);
        }
        nodes_[n].obb = obb.result();
      }
    });
    for (Node& node : nodes_)
      for (int lane = 0; lane < kLanes && node.child[lane] != kNoChild; ++lane) {
        const std::int32_t child = node.child[lane];
        set_lane(node.obbs, lane, child < 0 ? leaves_[~child].obb : nodes_[child].obb);
      }
  }
}

template <BoundingVolume V>
double VolumeTree<V>::measure_overlap() const {
  const double sum =
      parallel_sum(nodes_.size(), kLeafGrain, [&](std::size_t begin, std::size_t end) {
        double part = 0.0;
        for (std::size_t n = begin; n < end; ++n) part += overlap_ratio(nodes_[n]);
        return part;
      });
  return nodes_.empty() ? 1.0 : std::max(sum / static_cast<double>(nodes_.size()), 1e-3);
}

/// Overlapping children have a larger total area than their union.
template <BoundingVolume V>
double VolumeTree<V>::overlap_ratio(const Node& node) {
  double children = 0.0;
  for (int lane = 0; lane < kLanes && node.child[lane] != kNoChild; ++lane)
    children += half_area(lane_box(node.boxes, lane));
  const double own = half_area(node.box);
  return own > 0.0 ? std::min(children / own, kMaxRatio) : 1.0;
}

template <BoundingVolume V>
std::size_t VolumeTree<V>::bytes() const {
  return primitives_.bytes() + bytes_of(nodes_) + bytes_of(subtree_begin_) + bytes_of(leaves_) +
         points_.bytes() + edges_.bytes() + triangles_.bytes() + bytes_of(leaf_vertices_begin_) +
         bytes_of(leaf_vertices_);
}

template class VolumeTree<AabbVolume>;
template class VolumeTree<KDopVolume<14>>;
template class VolumeTree<KDopVolume<18>>;
template class VolumeTree<KDopVolume<26>>;
template class VolumeTree<ObbVolume>;

}  // namespace selvedge::detail
