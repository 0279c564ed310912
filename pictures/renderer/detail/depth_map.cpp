// SPDX-License-Identifier: MIT
#include <selvedge/pictures/renderer/detail/depth_map.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace selvedge::detail {

DepthMap::DepthMap(const Vec3f& to_light, float radius, int resolution)
    : to_light_(to_light), resolution_(resolution) {
  constexpr float rim = 2.0F;  // texels around the ball; lookups stay inside the map
  right_ = to_light.unitOrthogonal();
  up_ = to_light.cross(right_);
  centre_ = 0.5F * static_cast<float>(resolution);
  scale_ = (centre_ - rim) / radius;
  depth_.assign(static_cast<std::size_t>(resolution) * static_cast<std::size_t>(resolution),
                std::numeric_limits<float>::infinity());
}

namespace {

/// Range of the texels whose centre lies between the smallest and the largest of three values;
/// `end` is one past the last.
struct TexelRange {
  int begin, end;
};

TexelRange texel_range(float a, float b, float c, int resolution) {
  const float low = std::clamp(std::min({a, b, c}), 0.0F, static_cast<float>(resolution));
  const float high = std::clamp(std::max({a, b, c}), 0.0F, static_cast<float>(resolution));
  return {static_cast<int>(low + 0.5F), static_cast<int>(high + 0.5F)};
}

}  // namespace

void DepthMap::draw(std::span<const Vec3f> x, std::span<const Triangle> triangles) {
  std::vector<Place> places(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) places[i] = place(x[i]);
  for (const Triangle& t : triangles) {
    const Place& a = places[static_cast<std::size_t>(t[0])];
    const Place& b = places[static_cast<std::size_t>(t[1])];
    const Place& c = places[static_cast<std::size_t>(t[2])];
    const TexelRange columns = texel_range(a.u, b.u, c.u, resolution_);
    const TexelRange rows = texel_range(a.v, b.v, c.v, resolution_);
    if (columns.begin >= columns.end || rows.begin >= rows.end) continue;
    const float bu = b.u - a.u, bv = b.v - a.v, cu = c.u - a.u, cv = c.v - a.v;
    const float area = bu * cv - bv * cu;
    if (area == 0.0F) continue;
    // Barycentric coordinates of b and c are linear in (u, v).
    const float beta_u = cv / area, beta_v = -cu / area;
    const float gamma_u = -bv / area, gamma_v = bu / area;
    const float bd = b.depth - a.depth, cd = c.depth - a.depth;
    for (int row = rows.begin; row < rows.end; ++row) {
      const float v = static_cast<float>(row) + 0.5F - a.v;
      float* line =
          depth_.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(resolution_);
      for (int column = columns.begin; column < columns.end; ++column) {
        const float u = static_cast<float>(column) + 0.5F - a.u;
        const float beta = beta_u * u + beta_v * v, gamma = gamma_u * u + gamma_v * v;
        if (beta < 0.0F || gamma < 0.0F || beta + gamma > 1.0F) continue;
        line[column] = std::min(line[column], a.depth + beta * bd + gamma * cd);
      }
    }
  }
}

void DepthMap::find_ranges(float reach) {
  reach_ = reach;
  cells_ = (resolution_ + cell - 1) / cell;
  const auto side = static_cast<std::size_t>(cells_),
             texels = static_cast<std::size_t>(resolution_);
  constexpr float infinite = std::numeric_limits<float>::infinity();
  ranges_.assign(side * side, {infinite, -infinite});
  const auto widen = [](Range& range, const Range& other) {
    range = {std::min(range.least, other.least), std::max(range.greatest, other.greatest)};
  };
  for (std::size_t row = 0; row < texels; ++row)
    for (std::size_t column = 0; column < texels; ++column) {
      const float depth = depth_[row * texels + column];
      widen(ranges_[row / cell * side + column / cell], {depth, depth});
    }
  // Over the cells within reach, first along one axis, then along the other.
  const int cells_away = 1 + static_cast<int>(reach) / cell;
  for (const std::size_t along : {std::size_t{1}, side}) {
    const std::vector<Range> before = ranges_;
    for (std::size_t k = 0; k < ranges_.size(); ++k) {
      const int place = static_cast<int>(k / along % side);
      for (int other = place - cells_away; other <= place + cells_away; ++other) {
        const bool inside = other >= 0 && other < cells_;
        const auto away = static_cast<std::ptrdiff_t>(along) * (other - place);
        widen(ranges_[k],
              inside ? before[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(k) + away)]
                     : Range{infinite, infinite});
      }
    }
  }
}

}  // namespace selvedge::detail
