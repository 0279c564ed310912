// SPDX-License-Identifier: MIT
#include <selvedge/judge/detail/box_tree.h>

#include <numeric>
#include <utility>

namespace selvedge::judging {
namespace {

constexpr std::int32_t leaf_size = 4;

// Halves both bounds before adding them, so that the sum cannot overflow.
double middle(const ClosedBox& box, int axis) { return 0.5 * box.low[axis] + 0.5 * box.high[axis]; }

}  // namespace

BoxTree::BoxTree(std::vector<ClosedBox> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.reserve(boxes_.size());
  if (!boxes_.empty()) build(0, static_cast<std::int32_t>(boxes_.size()));
}

void BoxTree::build(std::int32_t begin, std::int32_t end) {
  const auto index = static_cast<std::int32_t>(nodes_.size());
  nodes_.push_back({{}, begin, end, 0});
  for (std::int32_t i = begin; i < end; ++i) nodes_[index].box.add(boxes_[order_[i]]);
  if (end - begin <= leaf_size) return;
  int axis = 0;
  const Vec3 side = 0.5 * nodes_[index].box.high - 0.5 * nodes_[index].box.low;
  side.maxCoeff(&axis);
  const std::int32_t split = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + split, order_.begin() + end,
                   [&](std::int32_t i, std::int32_t j) {
                     return std::pair(middle(boxes_[i], axis), i) <
                            std::pair(middle(boxes_[j], axis), j);
                   });
  build(begin, split);
  nodes_[index].right = static_cast<std::int32_t>(nodes_.size());
  build(split, end);
}

}  // namespace selvedge::judging
