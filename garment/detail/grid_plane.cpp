// SPDX-License-Identifier: MIT
#include <selvedge/garment/detail/grid_plane.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace selvedge::detail {
namespace {

__extension__ using Wide = __int128;

int sign_of(Wide value) { return (value > 0) - (value < 0); }

std::int64_t dot_from(const GridPoint& o, const GridPoint& a, const GridPoint& b) {
  return (a.x - o.x) * (b.x - o.x) + (a.y - o.y) * (b.y - o.y);
}

/// p lies on the line through a and b.
bool is_between(const GridPoint& a, const GridPoint& b, const GridPoint& p) {
  return std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) && std::min(a.y, b.y) <= p.y &&
         p.y <= std::max(a.y, b.y);
}

bool sides_meet(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridPoint& d) {
  const int abc = turn(a, b, c), abd = turn(a, b, d), cda = turn(c, d, a), cdb = turn(c, d, b);
  if (abc * abd < 0 && cda * cdb < 0) return true;
  return (abc == 0 && is_between(a, b, c)) || (abd == 0 && is_between(a, b, d)) ||
         (cda == 0 && is_between(c, d, a)) || (cdb == 0 && is_between(c, d, b));
}

}  // namespace

GridPlane::GridPlane(std::span<const Eigen::Vector2d> points) {
  Eigen::Vector2d low = points[0], high = points[0];
  for (const Eigen::Vector2d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double extent = (high - low).maxCoeff();
  unit_ = std::ldexp(1.0, std::ilogb(std::max(extent, 1e-200)) - 25);
  origin_ = (low / unit_).array().floor() * unit_;
}

GridPoint GridPlane::snap(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d q = (point - origin_) / unit_;
  return {std::llround(q.x()), std::llround(q.y())};
}

Eigen::Vector2d GridPlane::point(const GridPoint& p) const {
  return origin_ + unit_ * Eigen::Vector2d(static_cast<double>(p.x), static_cast<double>(p.y));
}

int turn(const GridPoint& a, const GridPoint& b, const GridPoint& c) {
  const std::int64_t left = (b.x - a.x) * (c.y - a.y), right = (b.y - a.y) * (c.x - a.x);
  return (left > right) - (left < right);
}

int in_circle(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridPoint& d) {
  const auto lift = [&](const GridPoint& p) { return Wide(dot_from(d, p, p)); };
  const auto cross = [&](const GridPoint& p, const GridPoint& q) {
    return Wide((p.x - d.x) * (q.y - d.y) - (p.y - d.y) * (q.x - d.x));
  };
  return sign_of(lift(a) * cross(b, c) + lift(b) * cross(c, a) + lift(c) * cross(a, b));
}

std::optional<std::pair<std::int32_t, std::int32_t>> loop_crossing(
    std::span<const GridPoint> loop) {
  const auto n = static_cast<std::int32_t>(loop.size());
  const auto at = [&](std::int32_t i) -> const GridPoint& { return loop[i < n ? i : i - n]; };
  for (std::int32_t i = 0; i < n; ++i)
    if (at(i) == at(i + 1)) return std::pair{i, i};
  if (n < 3) return std::pair{0, n - 1};
  for (std::int32_t i = 0; i < n; ++i) {
    const GridPoint &a = at(i), &b = at(i + 1), &c = at((i + 2) % n);
    if (turn(a, b, c) == 0 && dot_from(b, a, c) > 0) return std::pair{i, (i + 1) % n};
  }
  // A sweep in x over the left ends of the sides.
  const auto left = [&](std::int32_t i) { return std::min(at(i).x, at(i + 1).x); };
  const auto right = [&](std::int32_t i) { return std::max(at(i).x, at(i + 1).x); };
  std::vector<std::int32_t> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::int32_t i, std::int32_t j) {
    return std::pair(left(i), i) < std::pair(left(j), j);
  });
  for (std::int32_t k = 0; k < n; ++k) {
    for (std::int32_t m = k + 1; m < n && left(order[m]) <= right(order[k]); ++m) {
      const std::int32_t i = std::min(order[k], order[m]), j = std::max(order[k], order[m]);
      if (j == i + 1 || (i == 0 && j == n - 1)) continue;
      if (sides_meet(at(i), at(i + 1), at(j), at(j + 1))) return std::pair{i, j};
    }
  }
  return std::nullopt;
}

std::optional<std::int32_t> line_crossing(std::span<const GridPoint> points, std::int32_t sides,
                                          std::span<const std::array<std::int32_t, 2>> lines) {
  using Line = std::array<std::int32_t, 2>;
  const auto at = [&](std::int32_t i) -> const GridPoint& { return points[i]; };
  const auto meet = [&](const Line& p, const Line& q) {
    for (const int i : {0, 1})
      for (const int j : {0, 1}) {
        if (p[i] != q[j]) continue;
        // From their common end, one may lie on the other.
        const GridPoint &from = at(p[i]), &a = at(p[1 - i]), &b = at(q[1 - j]);
        return turn(from, a, b) == 0 && dot_from(from, a, b) > 0;
      }
    return sides_meet(at(p[0]), at(p[1]), at(q[0]), at(q[1]));
  };
  for (std::size_t k = 0; k < lines.size(); ++k) {
    bool is_fault = at(lines[k][0]) == at(lines[k][1]);
    for (std::int32_t i = 0; i < sides && !is_fault; ++i)
      is_fault = meet(lines[k], {i, (i + 1) % sides});
    for (std::size_t m = 0; m < k && !is_fault; ++m) is_fault = meet(lines[k], lines[m]);
    if (is_fault) return static_cast<std::int32_t>(k);
  }
  return std::nullopt;
}

}  // namespace selvedge::detail
