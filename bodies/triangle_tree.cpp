// SPDX-License-Identifier: MIT
#include <selvedge/bodies/internal/triangle_tree.h>

#include <algorithm>
#include <numeric>

namespace selvedge {
namespace {

constexpr std::int32_t kLeafSize = 4;

}  // namespace

// At the median of the middles along the axis in which they extend farthest.
void TriangleTree::split(std::span<const Vec3> x) {
  std::vector<Vec3> middle;  // three times
  middle.reserve(triangles_.size());
  for (const Triangle& t : triangles_) middle.emplace_back(x[t[0]] + x[t[1]] + x[t[2]]);
  order_.resize(triangles_.size());
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.push_back({.end = static_cast<std::int32_t>(order_.size())});
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    const Node node = nodes_[k];
    if (node.end - node.begin <= kLeafSize) continue;
    Vec3 low = middle[order_[node.begin]], high = low;
    for (std::int32_t i = node.begin; i < node.end; ++i) {
      low = low.cwiseMin(middle[order_[i]]);
      high = high.cwiseMax(middle[order_[i]]);
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const std::int32_t half = node.begin + (node.end - node.begin) / 2;
    const auto less = [&](std::int32_t a, std::int32_t b) {
      return middle[a][axis] != middle[b][axis] ? middle[a][axis] < middle[b][axis] : a < b;
    };
    std::nth_element(order_.begin() + node.begin, order_.begin() + half, order_.begin() + node.end,
                     less);
    nodes_[k].left = static_cast<std::int32_t>(nodes_.size());
    nodes_.push_back({.begin = node.begin, .end = half});
    nodes_.push_back({.begin = half, .end = node.end});
  }
}

void TriangleTree::fit(std::span<const Vec3> x) {
  if (triangles_.empty()) return;
  if (nodes_.empty()) split(x);
  for (std::size_t k = nodes_.size(); k-- > 0;) {
    Node& node = nodes_[k];
    if (node.left >= 0) {
      node.low = nodes_[node.left].low.cwiseMin(nodes_[node.left + 1].low);
      node.high = nodes_[node.left].high.cwiseMax(nodes_[node.left + 1].high);
      continue;
    }
    node.low = node.high = x[triangles_[order_[node.begin]][0]];
    for (std::int32_t i = node.begin; i < node.end; ++i)
      for (const std::int32_t v : triangles_[order_[i]]) {
        node.low = node.low.cwiseMin(x[v]);
        node.high = node.high.cwiseMax(x[v]);
      }
  }
}

}  // namespace selvedge
