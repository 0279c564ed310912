// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <array>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Wanted edge length inside a loop, and the distance from its sides.
class SizeField {
 public:
  using Side = std::array<Eigen::Vector2d, 2>;
  /// `length`: m, away from the loop. Near a shorter side it is that of the side, and grows with
  /// the distance. `lines` inside the loop count as sides. Throws std::invalid_argument where the
  /// field needs more than `cells` cells.
  SizeField(std::span<const Eigen::Vector2d> loop, std::span<const Side> lines, double length,
            std::int64_t cells);

  double size(const Eigen::Vector2d& p) const { return size_[cell_of(p)]; }  ///< m
  /// Distance from the sides, m, as far as it is below `length`; else at least that.
  double distance(const Eigen::Vector2d& p) const;

 private:
  std::size_t cell_of(const Eigen::Vector2d& p) const;
  void enter_sides();
  void grade();

  Eigen::Vector2d low_;
  double cell_;
  std::int64_t columns_, rows_;
  std::vector<double> size_;
  std::vector<Side> sides_;
  std::vector<std::int32_t> first_, list_;  // sides of each cell
};

}  // namespace selvedge::detail
