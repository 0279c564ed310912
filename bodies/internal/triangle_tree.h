// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge {

/// A tree of boxes over triangles, for the few of them that are near a point or in a box. Split
/// once, at the positions of the first fit; later fits keep the split.
class TriangleTree {
 public:
  TriangleTree() = default;
  /// Indices into the positions of `fit`.
  explicit TriangleTree(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {}

  bool empty() const { return triangles_.empty(); }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  /// Sets the positions of the vertices, m.
  void fit(std::span<const Vec3> x);

  /// Calls visit(k) for each triangle k whose box is within `reach`, m, of `q` in each coordinate,
  /// and for some others, in an order that depends on the positions of the first fit alone.
  template <class Visit>
  void for_each_near(const Vec3& q, double reach, Visit&& visit) const {
    for_each_in_box(q.array() - reach, q.array() + reach, visit);
  }

  /// The same for the triangles whose boxes meet the box from `low` to `high`, m.
  template <class Visit>
  void for_each_in_box(const Vec3& low, const Vec3& high, Visit&& visit) const {
    if (nodes_.empty()) return;
    std::int32_t stack[2 * kMaxDepth];
    int depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
      const Node& node = nodes_[stack[--depth]];
      if ((node.low.array() > high.array()).any() || (node.high.array() < low.array()).any())
        continue;
      if (node.left >= 0) {
        stack[depth++] = node.left;
        stack[depth++] = node.left + 1;
      } else {
        for (std::int32_t i = node.begin; i < node.end; ++i) visit(order_[i]);
      }
    }
  }

 private:
  static constexpr int kMaxDepth = 64;  // every level halves the number of triangles

  struct Node {
    Vec3 low = Vec3::Zero(), high = Vec3::Zero();
    std::int32_t begin = 0, end = 0, left = -1;  // children: left and left + 1; left < 0: a leaf
  };

  void split(std::span<const Vec3> x);

  std::vector<Triangle> triangles_;
  std::vector<std::int32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace selvedge
