// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <array>
#include <optional>
#include <span>
#include <utility>

namespace selvedge::detail {

/// A point of the plane in whole units, 0 to 2^26 in each coordinate. Signs of determinants are
/// then exact in integers of 64 and 128 bits.
struct GridPoint {
  std::int64_t x = 0, y = 0;
  bool operator==(const GridPoint&) const = default;
};

/// Rounds points (m) to a grid whose unit is a power of two, at most 2^-25 of their extent.
class GridPlane {
 public:
  explicit GridPlane(std::span<const Eigen::Vector2d> points);
  GridPoint snap(const Eigen::Vector2d& point) const;
  Eigen::Vector2d point(const GridPoint& p) const;
  double unit() const { return unit_; }  ///< m

 private:
  Eigen::Vector2d origin_;
  double unit_;
};

/// +1 if a, b, c run counter-clockwise, 0 if they lie on one line.
int turn(const GridPoint& a, const GridPoint& b, const GridPoint& c);
/// +1 if d lies inside the circle through a, b, c, which run counter-clockwise; 0 on it. Exact for
/// differences of coordinates below 2^30.
int in_circle(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridPoint& d);

/// Two sides of a closed loop that cross or touch, or none. Side i runs from point i to the next
/// one. Neighbours touch only if one folds back onto the other. A side of length 0 touches itself.
std::optional<std::pair<std::int32_t, std::int32_t>> loop_crossing(std::span<const GridPoint> loop);

/// The first line that crosses or touches a side of the loop or an earlier line elsewhere than at a
/// common end, or has no length; or none. The first `sides` points are the loop; a line names two
/// points.
std::optional<std::int32_t> line_crossing(std::span<const GridPoint> points, std::int32_t sides,
                                          std::span<const std::array<std::int32_t, 2>> lines);

}  // namespace selvedge::detail
