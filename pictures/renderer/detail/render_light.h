// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/pictures/renderer/detail/depth_map.h>
#include <selvedge/pictures/renderer/detail/render_geometry.h>

#include <vector>

namespace selvedge::detail {

/// The lights of a picture and their shadows.
class Lights {
 public:
  Lights(const Geometry& geometry, const View& view, const RenderConfig& config);

  const Vec3f& to_key() const { return key_.to_light(); }
  const Vec3f& to_fill() const { return fill_; }

  /// Share of the key light that reaches p, whose surface has unit normal n towards the light.
  float key(const Vec3f& p, const Vec3f& n) const;

  /// Light from the sky at p with unit normal n; an unshadowed upward normal gets 1. `openness`
  /// becomes the visible share of the sky above the surface.
  float sky(const Vec3f& p, const Vec3f& n, float& openness) const;

 private:
  static constexpr std::size_t lanes = 8;
  using Lanes = Eigen::Array<float, lanes, 1>;
  /// One axis of so many maps.
  struct LaneAxis {
    Lanes x = Lanes::Zero(), y = Lanes::Zero(), z = Lanes::Zero();
    void set(std::size_t lane, const Vec3f& axis);
    Lanes dot(const Vec3f& p) const { return x * p.x() + y * p.y() + z * p.z(); }
  };
  /// The axes of maps of one size. Lanes without a map have zeros, and so no weight.
  struct SkyAxes {
    LaneAxis right, up, to_light;
  };

  static Vec3f key_direction(const View& view);
  void make_sky(float radius, int directions);

  DepthMap key_;
  Vec3f fill_;
  std::vector<DepthMap> sky_;      // of one radius and resolution
  std::vector<SkyAxes> sky_axes_;  // of all of them, in order
  float sky_at_upward_normal_ = 1.0F;
};

}  // namespace selvedge::detail
