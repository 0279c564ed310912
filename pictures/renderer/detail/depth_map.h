// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace selvedge::detail {

using Vec3f = Eigen::Vector3f;

/// Shadow map of a light at infinity for a ball about the origin. Each texel stores the depth of
/// the first surface.
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
  const Vec3f& right() const { return right_; }
  const Vec3f& up() const { return up_; }
  const Vec3f& to_light() const { return to_light_; }
  float texel() const { return 1.0F / scale_; }  ///< m
  float centre() const { return centre_; }       ///< texels, u and v of the origin

  /// Prepares `near`. To be called after `draw`.
  void find_ranges(float reach);
  /// Bounds of all depths at most `reach` texels away along u and v; outside the map, depths are
  /// infinite.
  struct Range {
    float least, greatest;
  };
  Range near(float u, float v) const;

  /// Share of the light that reaches a position, 0 to 1: the bilinear mean over the four texels
  /// around it, or 1 outside the map.
  float lit(const Place& at) const;
  /// Depth stored in the texel that contains (u, v); infinite outside the map.
  float depth(float u, float v) const;

 private:
  Vec3f right_, up_, to_light_;
  float scale_, centre_;
  int resolution_;
  std::vector<float> depth_;

  static constexpr int cell = 8;  // texels
  int cells_ = 0;                 // along a side
  float reach_ = 0.0F;            // texels
  std::vector<Range> ranges_;     // of the cells
};

inline DepthMap::Range DepthMap::near(float u, float v) const {
  constexpr float infinite = std::numeric_limits<float>::infinity();
  const float end = static_cast<float>(resolution_);
  if (!(u >= -reach_ && v >= -reach_ && u < end + reach_ && v < end + reach_))
    return {infinite, infinite};
  if (!(u >= 0.0F && v >= 0.0F && u < end && v < end)) return {-infinite, infinite};
  return ranges_[static_cast<std::size_t>(v) / cell * static_cast<std::size_t>(cells_) +
                 static_cast<std::size_t>(u) / cell];
}

inline float DepthMap::lit(const Place& at) const {
  const float u = at.u - 0.5F, v = at.v - 0.5F;
  const float last = static_cast<float>(resolution_ - 1);
  if (!(u >= 0.0F && v >= 0.0F && u < last && v < last)) return 1.0F;
  const int column = static_cast<int>(u), row = static_cast<int>(v);
  const float fu = u - static_cast<float>(column), fv = v - static_cast<float>(row);
  const float* d = depth_.data() +
                   static_cast<std::size_t>(row) * static_cast<std::size_t>(resolution_) + column;
  const float* e = d + resolution_;
  const auto seen = [&](float depth) { return at.depth <= depth ? 1.0F : 0.0F; };
  const float above = seen(d[0]) + fu * (seen(d[1]) - seen(d[0]));
  const float below = seen(e[0]) + fu * (seen(e[1]) - seen(e[0]));
  return above + fv * (below - above);
}

inline float DepthMap::depth(float u, float v) const {
  const float end = static_cast<float>(resolution_);
  if (!(u >= 0.0F && v >= 0.0F && u < end && v < end))
    return std::numeric_limits<float>::infinity();
  return depth_[static_cast<std::size_t>(v) * static_cast<std::size_t>(resolution_) +
                static_cast<std::size_t>(u)];
}

}  // namespace selvedge::detail
