// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/garment/sewing_pattern.h>

#include <cstdint>
#include <numeric>
#include <vector>

namespace selvedge::detail {

/// Sets of panels that seams join, and which of them face the other way than the first of their
/// set.
class SideParity {
 public:
  explicit SideParity(std::size_t panels) : parent_(panels), odd_(panels, 0) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  std::int32_t root(std::int32_t panel) const {
    while (parent_[panel] != panel) panel = parent_[panel];
    return panel;
  }
  bool is_odd(std::int32_t panel) const {
    bool odd = false;
    for (; parent_[panel] != panel; panel = parent_[panel]) odd ^= odd_[panel] != 0;
    return odd;
  }
  bool are_joined(std::int32_t a, std::int32_t b) const { return root(a) == root(b); }
  bool are_opposite(std::int32_t a, std::int32_t b) const { return is_odd(a) != is_odd(b); }

  /// Returns false if a and b were joined before and the other way.
  bool join(std::int32_t a, std::int32_t b, bool opposite) {
    const std::int32_t to = root(a), from = root(b);
    if (to == from) return are_opposite(a, b) == opposite;
    odd_[from] = static_cast<char>(is_odd(a) ^ is_odd(b) ^ opposite);
    parent_[from] = to;
    return true;
  }

 private:
  std::vector<std::int32_t> parent_;
  std::vector<char> odd_;
};

/// How far each panel lies from the middle of the garment, towards the side from which its loop
/// runs counter-clockwise, m.
std::vector<double> outward_faces(const SewingPattern& pattern);

}  // namespace selvedge::detail
