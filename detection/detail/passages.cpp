// SPDX-License-Identifier: MIT
#include <selvedge/detection/detail/passages.h>
#include <selvedge/narrowphase/internal/triangles_cross.h>

#include <algorithm>
#include <tuple>
#include <vector>

namespace selvedge::detail {
namespace {

/// A triangle that leans with an edge on another triangle, on one side of it.
struct Leaf {
  bool on_first = true;  // whether the triangle leant on is of the first surface
  std::int32_t on = 0;
  Edge edge{};
  int side = 0;
  TrianglePair pair;
  bool operator<(const Leaf& l) const {
    return std::tie(on_first, on, edge, side, pair) <
           std::tie(l.on_first, l.on, l.edge, l.side, l.pair);
  }

  bool shares_place(const Leaf& l) const {
    return on_first == l.on_first && on == l.on && edge == l.edge;
  }
};

void add_leaves(const SurfaceView& of_on, std::int32_t on, const SurfaceView& of_leaf,
                std::int32_t leaf, Leaf found, std::vector<Leaf>& leaves) {
  const Triangle &t = of_on.triangles[on], &l = of_leaf.triangles[leaf];
  const auto& x = of_on.x_t0;
  const auto& y = of_leaf.x_t0;
  for (int k = 0; k < 3; ++k) {
    const std::int32_t v = l[k], w = l[(k + 1) % 3], apex = l[(k + 2) % 3];
    found.side = side_of_leaf({x[t[0]], x[t[1]], x[t[2]]}, y[v], y[w], y[apex]);
    if (found.side == 0) continue;
    found.on = on;
    found.edge = {std::min(v, w), std::max(v, w)};
    leaves.push_back(found);
  }
}

/// The pairs of leaves at one edge that lie on both sides of a triangle, sorted.
std::vector<TrianglePair> passing(std::vector<Leaf>& leaves) {
  std::sort(leaves.begin(), leaves.end());
  std::vector<TrianglePair> pairs;
  for (std::size_t begin = 0, end = 0; begin < leaves.size(); begin = end) {
    while (end < leaves.size() && leaves[end].shares_place(leaves[begin])) ++end;
    if (leaves[begin].side == leaves[end - 1].side) continue;  // sorted by side
    for (std::size_t i = begin; i < end; ++i) pairs.push_back(leaves[i].pair);
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace

void move_passages(const SurfaceView& a, const SurfaceView& b, TriangleMeetings& found) {
  std::vector<Leaf> leaves;
  for (const TrianglePair& pair : found.touches) {
    add_leaves(a, pair.triangle_a, b, pair.triangle_b, {.on_first = true, .pair = pair}, leaves);
    // The triangles of one surface have one set of numbers.
    add_leaves(b, pair.triangle_b, a, pair.triangle_a, {.on_first = &a == &b, .pair = pair},
               leaves);
  }
  const std::vector<TrianglePair> moved = passing(leaves);
  if (moved.empty()) return;
  std::erase_if(found.touches, [&](const TrianglePair& pair) {
    return std::binary_search(moved.begin(), moved.end(), pair);
  });
  found.crossings.insert(found.crossings.end(), moved.begin(), moved.end());
  std::sort(found.crossings.begin(), found.crossings.end());
}

}  // namespace selvedge::detail
