// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <cstddef>
#include <span>
#include <vector>

namespace selvedge::raster {

using Vec3f = Eigen::Vector3f;

/// What a light at infinity sees of a ball about the origin: the depth of the first surface.
class DepthMap {
 public:
  /// `to_light` is a unit vector; the ball of `radius` metres fills resolution x resolution texels.
  DepthMap(const Vec3f& to_light, float radius, int resolution);

  void draw(std::span<const Vec3f> x, std::span<const Triangle> triangles);

  struct Place {
    float u, v;   ///< texels
    float depth;  ///< m, away from the light
  };
  Place place(const Vec3f& p) const {
    return {p.dot(right_) * scale_ + centre_, p.dot(up_) * scale_ + centre_, -p.dot(to_light_)};
  }
  const Vec3f& to_light() const { return to_light_; }
  float texel() const { return 1.0F / scale_; }  ///< m

  /// Share of light, 0 to 1, of the four texels around a place, weighted bilinearly; 1 outside.
  float lit(const Place& at) const;
  /// Depth of the texel that holds a place; infinite outside.
  float depth(float u, float v) const;

 private:
  Vec3f right_, up_, to_light_;
  float scale_, centre_;
  int resolution_;
  std::vector<float> depth_;
};

}  // namespace selvedge::raster
