// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/detail/raster.h>
#include <selvedge/apps/render.h>

#include <array>
#include <span>
#include <vector>

namespace selvedge::raster {

using Vec2f = Eigen::Vector2f;

/// All surfaces joined, about an origin in their middle.
struct Geometry {
  Vec3 origin = Vec3::Zero();
  float radius = 1.0F;  ///< m, of the ball about the origin that the light fills
  float lowest = 0.0F;  ///< z of the lowest vertex
  std::vector<Vec3f> x;
  std::vector<Triangle> triangles;
  std::vector<std::array<Vec3f, 3>> normals;  ///< per triangle and corner, unit
  std::vector<Vec2f> material;                ///< per vertex; zero where a surface has none
  std::vector<std::int32_t> surface;          ///< of each triangle
};

/// Joins them. Throws std::invalid_argument for a broken index, coordinate or number of material
/// positions.
Geometry gather(std::span<const RenderSurface> surfaces);

inline Vec3f unit_or_zero(const Vec3f& v) {
  const float length = v.norm();
  return length > 0.0F ? Vec3f(v / length) : Vec3f::Zero();
}

}  // namespace selvedge::raster
