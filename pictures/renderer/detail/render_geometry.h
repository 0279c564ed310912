// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/pictures/renderer/detail/raster.h>
#include <selvedge/pictures/renderer/render.h>

#include <array>
#include <span>
#include <vector>

namespace selvedge::detail {

using Vec2f = Eigen::Vector2f;

/// All surfaces in one mesh, relative to an origin in their middle.
struct Geometry {
  Vec3 origin = Vec3::Zero();
  float radius = 1.0F;  ///< m, of the ball about the origin that the lights cover
  float lowest = 0.0F;  ///< m, z of the lowest vertex, relative to the origin
  std::vector<Vec3f> x;
  std::vector<Triangle> triangles;
  std::vector<std::array<Vec3f, 3>> normals;  ///< unit normal per triangle and corner
  std::vector<Vec2f> material;                ///< per vertex; zero if the surface has no positions
  std::vector<std::int32_t> surface;          ///< index of the surface of each triangle
};

/// Joins the surfaces. Throws std::invalid_argument for an index out of range, a coordinate that is
/// not finite, or a wrong number of material positions.
Geometry gather(std::span<const RenderSurface> surfaces);

inline Vec3f unit_or_zero(const Vec3f& v) {
  const float length = v.norm();
  return length > 0.0F ? Vec3f(v / length) : Vec3f::Zero();
}

}  // namespace selvedge::detail
