// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace selvedge::judging {

/// A closed axis-aligned box; it is empty until a point is added.
struct ClosedBox {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());

  void add(const Vec3& x) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  void add(const ClosedBox& box) {
    low = low.cwiseMin(box.low);
    high = high.cwiseMax(box.high);
  }
  bool meets(const ClosedBox& box) const {
    return low[0] <= box.high[0] && box.low[0] <= high[0] && low[1] <= box.high[1] &&
           box.low[1] <= high[1] && low[2] <= box.high[2] && box.low[2] <= high[2];
  }
  bool contains(const Vec3& x) const { return meets({x, x}); }
  /// Squared distance from x to the box; 0 if x is inside.
  double squared_distance(const Vec3& x) const {
    const Vec3 below = (low - x).cwiseMax(0.0), above = (x - high).cwiseMax(0.0);
    return below.squaredNorm() + above.squaredNorm();
  }
};

/// A binary tree of boxes, split at the median of the longest side. The judge has its own search,
/// so that a fault of a broad phase cannot affect it. Overlap queries only compare doubles, so they
/// are exact.
class BoxTree {
 public:
  explicit BoxTree(std::vector<ClosedBox> boxes);

  const std::vector<ClosedBox>& boxes() const { return boxes_; }

  /// Calls found(index) for every box b with enter(b). If enter is true for a box, it must also be
  /// true for every box that contains it.
  template <class Enter, class Found>
  void visit(const Enter& enter, const Found& found) const {
    if (!nodes_.empty()) visit_below(0, enter, found);
  }

  /// Calls found(index) for every box that overlaps or touches `box`.
  template <class Found>
  void find_meeting(const ClosedBox& box, const Found& found) const {
    visit([&box](const ClosedBox& b) { return box.meets(b); }, found);
  }

  /// Calls found(i, j) once for every pair of different boxes that overlap or touch, i < j.
  template <class Found>
  void find_meeting_pairs(const Found& found) const {
    if (!nodes_.empty()) pairs_within(0, found);
  }

  /// Calls measure(index), which returns a squared distance from x, for the boxes that may contain
  /// something nearer than the nearest so far. Returns the smallest squared distance, or any one
  /// that is at most `enough`.
  template <class Measure>
  double nearest(const Vec3& x, double enough, const Measure& measure) const {
    double best = std::numeric_limits<double>::infinity();
    if (!nodes_.empty()) search_below(0, x, enough, measure, best);
    return best;
  }

 private:
  struct Node {
    ClosedBox box;
    std::int32_t begin, end;  // leaf: range of its boxes in order_
    std::int32_t right;       // inner: right child (the left one is the next node); leaf: 0
  };

  void build(std::int32_t begin, std::int32_t end);

  template <class Enter, class Found>
  void visit_below(std::int32_t node_index, const Enter& enter, const Found& found) const {
    const Node& node = nodes_[node_index];
    if (!enter(node.box)) return;
    if (node.right == 0) {
      for (std::int32_t i = node.begin; i < node.end; ++i)
        if (enter(boxes_[order_[i]])) found(order_[i]);
      return;
    }
    visit_below(node_index + 1, enter, found);
    visit_below(node.right, enter, found);
  }

  std::int32_t left_of(std::int32_t node) const { return node + 1; }
  bool is_leaf(std::int32_t node) const { return nodes_[node].right == 0; }

  template <class Found>
  void offer(std::int32_t a, std::int32_t b, const Found& found) const {
    const std::int32_t i = order_[a], j = order_[b];
    if (boxes_[i].meets(boxes_[j])) found(std::min(i, j), std::max(i, j));
  }

  template <class Found>
  void pairs_within(std::int32_t index, const Found& found) const {
    const Node& node = nodes_[index];
    if (is_leaf(index)) {
      for (std::int32_t a = node.begin; a < node.end; ++a)
        for (std::int32_t b = a + 1; b < node.end; ++b) offer(a, b, found);
      return;
    }
    pairs_within(left_of(index), found);
    pairs_within(node.right, found);
    pairs_between(left_of(index), node.right, found);
  }

  template <class Found>
  void pairs_between(std::int32_t s, std::int32_t t, const Found& found) const {
    const Node &a = nodes_[s], &b = nodes_[t];
    if (!a.box.meets(b.box)) return;
    if (is_leaf(s) && is_leaf(t)) {
      for (std::int32_t i = a.begin; i < a.end; ++i)
        if (b.box.meets(boxes_[order_[i]]))
          for (std::int32_t j = b.begin; j < b.end; ++j) offer(i, j, found);
      return;
    }
    // The node with more boxes is split first.
    if (is_leaf(t) || (!is_leaf(s) && a.end - a.begin >= b.end - b.begin)) {
      pairs_between(left_of(s), t, found);
      pairs_between(a.right, t, found);
    } else {
      pairs_between(s, left_of(t), found);
      pairs_between(s, b.right, found);
    }
  }

  template <class Measure>
  void search_below(std::int32_t node_index, const Vec3& x, double enough, const Measure& measure,
                    double& best) const {
    const Node& node = nodes_[node_index];
    if (node.right == 0) {
      for (std::int32_t i = node.begin; i < node.end; ++i)
        if (boxes_[order_[i]].squared_distance(x) < best) best = std::min(best, measure(order_[i]));
      return;
    }
    std::int32_t near = node_index + 1, far = node.right;
    double near_distance = nodes_[near].box.squared_distance(x);
    double far_distance = nodes_[far].box.squared_distance(x);
    if (far_distance < near_distance) {
      std::swap(near, far);
      std::swap(near_distance, far_distance);
    }
    if (near_distance < best) search_below(near, x, enough, measure, best);
    if (far_distance < best && best > enough) search_below(far, x, enough, measure, best);
  }

  std::vector<ClosedBox> boxes_;
  std::vector<std::int32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace selvedge::judging
