// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/pictures/renderer/detail/render_light.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace selvedge::detail {
namespace {

/// Tangent of half the angular diameter of the key light. The width of a half-shadow is this factor
/// times the distance to the occluder.
constexpr float key_half_angle_tangent = 0.075F;
/// The search radius exceeds that of the widest filter. Near the rim, where its samples are sparse,
/// occluders matter less.
constexpr float search_texels = 32.0F, widest_texels = 22.0F;

/// A point of the unit disc and its distance from the middle.
struct DiscPoint {
  float x, y, radius;
};

/// n points in the unit disc along a golden-angle spiral. A power of 1/2 spreads them evenly; a
/// larger power makes them denser towards the middle.
template <std::size_t n>
std::array<DiscPoint, n> disc(float power) {
  std::array<DiscPoint, n> points;
  constexpr float golden_angle = 2.39996323F;
  for (std::size_t i = 0; i < n; ++i) {
    const float r = std::pow((static_cast<float>(i) + 0.5F) / static_cast<float>(n), power);
    const float angle = golden_angle * static_cast<float>(i);
    points[i] = {r * std::cos(angle), r * std::sin(angle), r};
  }
  return points;
}

}  // namespace

Lights::Lights(const Geometry& geometry, const View& view, const RenderConfig& config)
    : key_(key_direction(view), geometry.radius, config.shadow_resolution),
      fill_(unit_or_zero(view.right - 0.6F * view.forward + Vec3f(0.0F, 0.0F, 0.3F))) {
  make_sky(geometry.radius, config.sky_directions);
  parallel_for(sky_.size() + 1, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      (i == 0 ? key_ : sky_[i - 1]).draw(geometry.x, geometry.triangles);
  });
  key_.find_ranges(search_texels + 1.0F);
}

/// Direction to the key light: behind the viewer's left shoulder, 48° high. The visible side is
/// thus lit from any viewpoint.
Vec3f Lights::key_direction(const View& view) {
  Vec3f towards = Vec3f(-view.forward.x(), -view.forward.y(), 0.0F);
  if (towards.norm() < 0.1F) towards = Vec3f(-view.up.x(), -view.up.y(), 0.0F);
  towards = unit_or_zero(towards);
  const Vec3f left(towards.y(), -towards.x(), 0.0F);
  constexpr float degree = std::numbers::pi_v<float> / 180.0F;
  constexpr float azimuth = 48.0F * degree, height = 48.0F * degree;
  return std::cos(height) * (std::cos(azimuth) * towards + std::sin(azimuth) * left) +
         Vec3f(0.0F, 0.0F, std::sin(height));
}

/// Creates depth maps for directions that a golden-angle spiral spreads evenly over the upper
/// hemisphere.
void Lights::make_sky(float radius, int directions) {
  constexpr int sky_resolution = 256;
  constexpr float golden_angle = 2.39996323F;
  float sum = 0.0F;
  for (int k = 0; k < directions; ++k) {
    const float z = (static_cast<float>(k) + 0.5F) / static_cast<float>(directions);
    const float r = std::sqrt(1.0F - z * z), angle = golden_angle * static_cast<float>(k);
    sky_.emplace_back(Vec3f(r * std::cos(angle), r * std::sin(angle), z), radius, sky_resolution);
    sum += z;
  }
  if (sum > 0.0F) sky_at_upward_normal_ = sum;
  sky_axes_.resize((sky_.size() + lanes - 1) / lanes);
  for (std::size_t k = 0; k < sky_.size(); ++k) {
    SkyAxes& axes = sky_axes_[k / lanes];
    axes.right.set(k % lanes, sky_[k].right());
    axes.up.set(k % lanes, sky_[k].up());
    axes.to_light.set(k % lanes, sky_[k].to_light());
  }
}

void Lights::LaneAxis::set(std::size_t lane, const Vec3f& axis) {
  const auto i = static_cast<Eigen::Index>(lane);
  x[i] = axis.x();
  y[i] = axis.y();
  z[i] = axis.z();
}

// R. Fernando, "Percentage-closer soft shadows", SIGGRAPH 2005 sketches: the mean depth of the
// occluders near a point gives the width of the half-shadow, over which the light is then averaged.
float Lights::key(const Vec3f& p, const Vec3f& n) const {
  static constexpr std::size_t search_count = 56, filter_count = 96;
  static const std::array<DiscPoint, search_count> search = disc<search_count>(0.7F);
  static const std::array<DiscPoint, filter_count> filter = disc<filter_count>(0.5F);
  // The point is moved off the surface by more than the depth varies within the filter, so that the
  // surface does not shadow itself.
  const float texel = key_.texel();
  constexpr float offset_texels = 2.5F;
  const DepthMap::Place at = key_.place(p + offset_texels * texel * n);
  const DepthMap::Range near = key_.near(at.u, at.v);
  if (near.least >= at.depth) return 1.0F;  // no sample is hidden
  // Within a wide filter, a surface inclined to the light would shadow itself. The bias prevents
  // this.
  const float cosine = std::clamp(n.dot(key_.to_light()), 0.1F, 1.0F);
  const float slope = std::sqrt(1.0F - cosine * cosine) / cosine;
  constexpr float steepest = 4.0F;
  const float bias = std::min(slope, steepest) * texel;
  // All samples are hidden.
  if (near.greatest < at.depth - bias * (0.5F + search_texels)) return 0.0F;
  float sum = 0.0F;
  int hidden = 0;
  for (const DiscPoint& q : search) {
    const float depth = key_.depth(at.u + search_texels * q.x, at.v + search_texels * q.y);
    if (depth >= at.depth - bias * (0.5F + search_texels * q.radius)) continue;
    sum += depth;
    ++hidden;
  }
  if (hidden == 0) return 1.0F;
  constexpr float narrowest_texels = 1.5F;
  const float gap = at.depth - sum / static_cast<float>(hidden);
  const float width =
      std::clamp(gap * key_half_angle_tangent / texel, narrowest_texels, widest_texels);
  const auto lit_from = [&](std::size_t first, std::size_t step) {
    float sum_lit = 0.0F;
    for (std::size_t i = first; i < filter_count; i += step) {
      const DiscPoint& q = filter[i];
      sum_lit += key_.lit(
          {at.u + width * q.x, at.v + width * q.y, at.depth - bias * (0.5F + width * q.radius)});
    }
    return sum_lit;
  };
  // A quarter of the samples distinguishes full light from full shadow. Only the half-shadow needs
  // all samples.
  constexpr std::size_t stride = 4;
  const float quarter = lit_from(0, stride);
  if (quarter == 0.0F || quarter == static_cast<float>(filter_count / stride))
    return quarter > 0.0F ? 1.0F : 0.0F;
  float lit = quarter;
  for (std::size_t first = 1; first < stride; ++first) lit += lit_from(first, stride);
  return lit / static_cast<float>(filter_count);
}

float Lights::sky(const Vec3f& p, const Vec3f& n, float& openness) const {
  openness = 1.0F;
  if (sky_.empty()) return 0.0F;
  constexpr float offset_texels = 1.5F, bias_texels = 1.0F;
  const float texel = sky_.front().texel(), scale = 1.0F / texel, centre = sky_.front().centre();
  const Vec3f at = p + offset_texels * texel * n;
  float sum = 0.0F, all = 0.0F;
  for (std::size_t c = 0; c < sky_axes_.size(); ++c) {
    const SkyAxes& axes = sky_axes_[c];
    const Lanes weight = axes.to_light.dot(n);
    if (!(weight > 0.0F).any()) continue;
    const Lanes u = axes.right.dot(at) * scale + centre, v = axes.up.dot(at) * scale + centre;
    const Lanes depth = -axes.to_light.dot(at) - bias_texels * texel;
    for (Eigen::Index i = 0; i < weight.size(); ++i) {
      if (!(weight[i] > 0.0F)) continue;
      const DepthMap& map = sky_[c * lanes + static_cast<std::size_t>(i)];
      all += weight[i];
      sum += weight[i] * map.lit({u[i], v[i], depth[i]});
    }
  }
  if (all > 0.0F) openness = sum / all;
  return sum / sky_at_upward_normal_;
}

}  // namespace selvedge::detail
