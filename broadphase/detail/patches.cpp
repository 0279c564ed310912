// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/patches.h>

#include <algorithm>
#include <tuple>

namespace selvedge::detail {
namespace {

constexpr std::int32_t kBorder = -1;

int lanes_of(int items, int block) { return std::min(kLanes, items - block * kLanes); }

/// Whether every point of the leaf is a corner, and every edge a side, of one of its triangles.
bool owns_only_parts(const BoundingVolumeTree& tree, const TreeLeaf& leaf) {
  const auto some_triangle = [&](auto holds) {
    for (int b = 0; b < leaf.triangle_blocks; ++b)
      for (int i = 0; i < lanes_of(leaf.triangles, b); ++i) {
        const TriangleBlock& t = tree.triangles(leaf)[b];
        if (holds(t.v0[i], t.v1[i], t.v2[i])) return true;
      }
    return false;
  };
  for (int b = 0; b < leaf.point_blocks; ++b)
    for (int i = 0; i < lanes_of(leaf.points, b); ++i) {
      const std::int32_t p = tree.points(leaf)[b].id[i];
      if (!some_triangle([p](auto x, auto y, auto z) { return p == x || p == y || p == z; }))
        return false;
    }
  for (int b = 0; b < leaf.edge_blocks; ++b)
    for (int i = 0; i < lanes_of(leaf.edges, b); ++i) {
      const EdgeBlock& e = tree.edges(leaf)[b];
      const std::int32_t p = e.v0[i], q = e.v1[i];
      if (!some_triangle([p, q](auto x, auto y, auto z) {
            return (p == x || p == y || p == z) && (q == x || q == y || q == z);
          }))
        return false;
    }
  return true;
}

}  // namespace

void Patches::number_triangles(const BoundingVolumeTree& tree, std::int32_t child) {
  Patch& patch = child < 0 ? leaves_[~child] : nodes_[child];
  patch.begin = static_cast<std::uint32_t>(order_.size());
  patch.is_disc_like = true;
  if (child < 0) {
    const TreeLeaf& leaf = tree.leaf(~child);
    for (int b = 0; b < leaf.triangle_blocks; ++b)
      for (int i = 0; i < lanes_of(leaf.triangles, b); ++i)
        order_.push_back(tree.triangles(leaf)[b].id[i]);
    patch.is_disc_like = owns_only_parts(tree, leaf);
  } else {
    for (const std::int32_t c : tree.node(child).child) {
      if (c == kNoChild) break;
      number_triangles(tree, c);
      if (!(c < 0 ? leaves_[~c] : nodes_[c]).is_disc_like) nodes_[child].is_disc_like = false;
    }
  }
  (child < 0 ? leaves_[~child] : nodes_[child]).end = static_cast<std::uint32_t>(order_.size());
}

void Patches::find_neighbours(std::span<const Triangle> triangles) {
  struct Side {
    std::int32_t lo, hi;
    std::int32_t place;
    std::int8_t corner;
    bool upwards;  ///< goes from the lower to the higher vertex
  };
  std::vector<Side> sides;
  sides.reserve(3 * order_.size());
  for (std::size_t p = 0; p < order_.size(); ++p) {
    const Triangle& t = triangles[order_[p]];
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = t[k], b = t[(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<std::int32_t>(p),
                       static_cast<std::int8_t>(k), a < b});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.lo, a.hi, a.place, a.corner) < std::tie(b.lo, b.hi, b.place, b.corner);
  });
  beyond_.assign(order_.size(), {kBorder, kBorder, kBorder});
  faulty_.assign(order_.size(), 0);
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].lo == sides[i].lo && sides[end].hi == sides[i].hi)
      ++end;
    const bool is_pair = end == i + 2 && sides[i].upwards != sides[i + 1].upwards;
    if (is_pair) {
      beyond_[sides[i].place][sides[i].corner] = sides[i + 1].place;
      beyond_[sides[i + 1].place][sides[i + 1].corner] = sides[i].place;
    }
    const bool is_degenerate = sides[i].lo == sides[i].hi;
    if ((end > i + 1 && !is_pair) || is_degenerate)
      for (std::size_t j = i; j < end; ++j) faulty_[sides[j].place] = 1;
    i = end;
  }
}

bool Patches::is_connected(const Patch& patch) {
  if (patch.begin == patch.end) return false;
  std::fill(reached_.begin() + patch.begin, reached_.begin() + patch.end, 0);
  stack_.assign(1, static_cast<std::int32_t>(patch.begin));
  reached_[patch.begin] = 1;
  std::size_t count = 0;
  while (!stack_.empty()) {
    const std::int32_t p = stack_.back();
    stack_.pop_back();
    ++count;
    for (const std::int32_t q : beyond_[p]) {
      if (q < static_cast<std::int32_t>(patch.begin) || q >= static_cast<std::int32_t>(patch.end))
        continue;
      if (reached_[q]) continue;
      reached_[q] = 1;
      stack_.push_back(q);
    }
  }
  return count == patch.end - patch.begin;
}

/// Traces the contour, or finds that the patch is not disc-like.
void Patches::trace(Patch& patch, std::span<const Triangle> triangles) {
  const bool sound = patch.is_disc_like &&
                     std::find(faulty_.begin() + patch.begin, faulty_.begin() + patch.end, 1) ==
                         faulty_.begin() + patch.end &&
                     is_connected(patch);
  patch.is_disc_like = false;
  if (!sound) return;
  const auto inside = [&](std::int32_t p) {
    return p >= static_cast<std::int32_t>(patch.begin) && p < static_cast<std::int32_t>(patch.end);
  };
  std::vector<std::int32_t> starts;
  bool simple = true;
  for (std::uint32_t p = patch.begin; p < patch.end; ++p)
    for (int k = 0; k < 3; ++k) {
      if (inside(beyond_[p][k])) continue;
      const Triangle& t = triangles[order_[p]];
      if (next_[t[k]] >= 0) simple = false;
      next_[t[k]] = t[(k + 1) % 3];
      starts.push_back(t[k]);
    }
  patch.contour_begin = static_cast<std::uint32_t>(contours_.size());
  if (simple && !starts.empty()) {
    std::int32_t v = starts.front();
    do {
      contours_.push_back(v);
      v = next_[v];
    } while (v >= 0 && v != starts.front() &&
             contours_.size() - patch.contour_begin <= starts.size());
    patch.is_disc_like =
        v == starts.front() && contours_.size() - patch.contour_begin == starts.size();
  }
  if (!patch.is_disc_like) contours_.resize(patch.contour_begin);
  patch.contour_end = static_cast<std::uint32_t>(contours_.size());
  for (const std::int32_t v : starts) next_[v] = -1;
}

void Patches::build(const BoundingVolumeTree& tree, std::span<const Triangle> triangles,
                    std::size_t vertices) {
  order_.clear();
  nodes_.assign(tree.node_count(), {});
  leaves_.assign(tree.leaf_count(), {});
  contours_.clear();
  number_triangles(tree, tree.root());
  find_neighbours(triangles);
  reached_.assign(order_.size(), 0);
  next_.assign(vertices, -1);
  for (Patch& patch : nodes_) trace(patch, triangles);
  for (Patch& patch : leaves_) trace(patch, triangles);
}

std::size_t Patches::bytes() const {
  const auto of = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
  return of(order_) + of(beyond_) + of(faulty_) + of(nodes_) + of(leaves_) + of(contours_) +
         of(next_) + of(stack_) + of(reached_);
}

}  // namespace selvedge::detail
