// SPDX-License-Identifier: MIT
//
// Visibility and shading are separate: the rasteriser first determines which triangle each sample
// of the picture sees. Then every triangle visible in a pixel is shaded once, at the mean position
// of its samples.
#include <selvedge/core/base/parallel.h>
#include <selvedge/pictures/renderer/detail/render_light.h>
#include <selvedge/pictures/renderer/render.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

using detail::Band;
using detail::Geometry;
using detail::Lights;
using detail::unit_or_zero;
using detail::Vec2f;
using detail::Vec3f;
using detail::View;

// Brightness of an unshadowed white surface that faces the light.
constexpr float key_light = 0.72F;
constexpr float fill_light = 0.10F;
constexpr float sky_light = 0.42F;
constexpr float bounce_light = 0.16F;  // light from the ground on a downward normal
constexpr float stray_light = 0.045F;  // constant light that also reaches the deepest fold
const Vec3f key_colour(1.0F, 0.975F, 0.94F), sky_colour(0.95F, 0.98F, 1.0F);

// ---- surfaces ------------------------------------------------------------------------------

/// Mean over [x - f/2, x + f/2] of a pattern of lines of width w, one centred on every integer.
float line_share(float x, float w, float f) {
  const auto integral = [w](float t) {
    const float whole = std::floor(t);
    return whole * w + std::min(t - whole, w);
  };
  f = std::max(f, 1e-4F);
  x += 0.5F * w;
  return (integral(x + 0.5F * f) - integral(x - 0.5F * f)) / f;
}

/// Factor by which a grid of fine lines in the material darkens the cloth. Every fifth line is
/// heavier.
float grid_factor(const Vec2f& material, float spacing, float footprint) {
  constexpr float fine_width = 0.035F, heavy_width = 0.014F, fine_ink = 0.16F, heavy_ink = 0.28F;
  float factor = 1.0F;
  for (const float position : {material.x() / spacing, material.y() / spacing}) {
    const float f = footprint / spacing;
    factor *= 1.0F - fine_ink * line_share(position, fine_width, f);
    factor *= 1.0F - heavy_ink * line_share(position / 5.0F, heavy_width, f / 5.0F);
  }
  return factor;
}

struct Hit {
  Vec3f p, n;       ///< n: unit normal on the viewer's side
  Vec3f to_viewer;  ///< unit
  float distance;   ///< m
  bool front;
  Vec2f material;
};

class Shader {
 public:
  Shader(std::span<const RenderSurface> surfaces, const Geometry& geometry, const View& view,
         const Lights& lights)
      : surfaces_(surfaces), geometry_(geometry), view_(view), lights_(lights) {}

  /// Colour of a triangle at a point of the picture.
  Vec3f shade(std::int32_t triangle, float x, float y) const {
    const RenderSurface& surface =
        surfaces_[static_cast<std::size_t>(geometry_.surface[static_cast<std::size_t>(triangle)])];
    const Hit hit = find_hit(static_cast<std::size_t>(triangle), view_.ray(x, y));
    return colour(surface, hit);
  }

 private:
  Hit find_hit(std::size_t triangle, const Vec3f& ray) const;
  Vec3f colour(const RenderSurface& surface, const Hit& hit) const;

  std::span<const RenderSurface> surfaces_;
  const Geometry& geometry_;
  const View& view_;
  const Lights& lights_;
};

// T. Möller, B. Trumbore, "Fast, minimum storage ray-triangle intersection", J. Graphics Tools
// 1997. The point lies on the triangle up to rounding errors, so the weights are only clamped.
Hit Shader::find_hit(std::size_t triangle, const Vec3f& ray) const {
  const Triangle& t = geometry_.triangles[triangle];
  const auto corner = [&](std::size_t i) { return static_cast<std::size_t>(t[i]); };
  const Vec3f &a = geometry_.x[corner(0)], &b = geometry_.x[corner(1)], &c = geometry_.x[corner(2)];
  const Vec3f ab = b - a, ac = c - a, from_a = view_.eye - a;
  const Vec3f across = ray.cross(ac);
  const float determinant = ab.dot(across);
  float beta = 1.0F / 3.0F, gamma = 1.0F / 3.0F;
  if (determinant != 0.0F) {
    beta = std::clamp(from_a.dot(across) / determinant, 0.0F, 1.0F);
    gamma = std::clamp(ray.dot(from_a.cross(ab)) / determinant, 0.0F, 1.0F - beta);
  }
  const float alpha = 1.0F - beta - gamma;
  const auto& normals = geometry_.normals[triangle];
  Hit hit;
  hit.p = alpha * a + beta * b + gamma * c;
  const Vec3f to_eye = view_.eye - hit.p;
  hit.distance = to_eye.norm();
  hit.to_viewer = to_eye / hit.distance;
  hit.front = determinant > 0.0F;
  hit.n = unit_or_zero(alpha * normals[0] + beta * normals[1] + gamma * normals[2]);
  if (!hit.front) hit.n = -hit.n;
  // Near a silhouette, the interpolated normal may point away from the viewer. It is then turned
  // until it is almost perpendicular to the direction of view.
  constexpr float rim = 0.02F;
  const float facing = hit.n.dot(hit.to_viewer);
  if (facing < rim) hit.n = unit_or_zero(hit.n + (rim - facing) * hit.to_viewer);
  hit.material = alpha * geometry_.material[corner(0)] + beta * geometry_.material[corner(1)] +
                 gamma * geometry_.material[corner(2)];
  return hit;
}

Vec3f Shader::colour(const RenderSurface& surface, const Hit& hit) const {
  const float facing = std::max(hit.n.dot(hit.to_viewer), 0.0F);
  Vec3f albedo = (hit.front ? surface.front : surface.back).cast<float>();
  if (!surface.material.empty() && surface.grid > 0.0) {
    constexpr float least_facing = 0.1F;
    const float footprint = hit.distance / view_.focal / std::max(facing, least_facing);
    albedo *= grid_factor(hit.material, static_cast<float>(surface.grid), footprint);
  }
  const float towards_key = std::max(hit.n.dot(lights_.to_key()), 0.0F);
  const float key = towards_key > 0.0F ? towards_key * lights_.key(hit.p, hit.n) : 0.0F;
  float openness = 1.0F;
  const float sky = lights_.sky(hit.p, hit.n, openness);
  const float fill = std::max(hit.n.dot(lights_.to_fill()), 0.0F) * (0.3F + 0.7F * openness);
  const float bounce = 0.5F * (1.0F - hit.n.z()) * (0.4F + 0.6F * openness);
  const Vec3f light = key_light * key * key_colour + sky_light * sky * sky_colour +
                      Vec3f::Constant(fill_light * fill + bounce_light * bounce + stray_light);
  Vec3f result = albedo.cwiseProduct(light);
  if (surface.sheen > 0.0) {
    const float edge = 1.0F - facing;
    const float strength = static_cast<float>(surface.sheen) * edge * edge * edge;
    const Vec3f fibre = 0.5F * albedo + Vec3f::Constant(0.5F * albedo.maxCoeff());
    result += strength * fibre.cwiseProduct(light);
  }
  return result;
}

// ---- ground and background -----------------------------------------------------------------

/// A light backdrop, brighter in the middle of the picture, and an infinite floor that shows the
/// shadows of the scene.
class Background {
 public:
  Background(const Geometry& geometry, const View& view, const Lights& lights,
             const RenderConfig& config)
      : view_(view), lights_(lights), reach_(reach_in_radii * geometry.radius) {
    if (!config.ground) return;
    // The floor lies just below the objects that stand on it.
    constexpr float gap_in_radii = 1e-3F;
    const float level = std::isfinite(config.ground_z)
                            ? static_cast<float>(config.ground_z - geometry.origin.z())
                            : geometry.lowest;
    ground_ = level - gap_in_radii * geometry.radius;
    if (view.eye.z() > *ground_) make_ambient();
  }

  Vec3f colour(float x, float y) const {
    const float u = (x - 0.5F * static_cast<float>(view_.width)) / static_cast<float>(view_.height);
    const float v =
        (y - 0.46F * static_cast<float>(view_.height)) / static_cast<float>(view_.height);
    const float away = std::min(u * u + v * v, 1.0F);
    const Vec3f middle(0.90F, 0.905F, 0.91F), corner(0.58F, 0.605F, 0.64F);
    return (middle + (corner - middle) * away) * shadow(view_.ray(x, y));
  }

 private:
  static constexpr float reach_in_radii = 2.6F;
  static constexpr int cells = 320;            // of ambient light along each side of the floor
  static constexpr int smoothing_passes = 12;  // along x and y in turn

  /// Points of the grid of ambient light, along x and y.
  struct GridBox {
    std::array<std::size_t, 2> begin, end;
  };

  float shadow(const Vec3f& ray) const;
  Vec3f on_floor(const Vec3f& ray) const {
    return view_.eye + ((*ground_ - view_.eye.z()) / ray.z()) * ray;
  }
  GridBox seen_box() const;
  void make_ambient();
  void smooth_ambient(const GridBox& box);
  float ambient(const Vec3f& p) const;

  const View& view_;
  const Lights& lights_;
  float reach_;  ///< m, distance from the middle at which shadows have faded
  std::optional<float> ground_;
  std::vector<float> ambient_;
};

/// The part of the grid that the picture shows, and as many points around it as change its smoothed
/// values; all of it if the horizon is in the picture.
Background::GridBox Background::seen_box() const {
  constexpr std::size_t points = cells + 1;
  constexpr float margin = 2.0F + smoothing_passes / 2.0F;
  std::array<float, 2> low = {cells, cells}, high = {0.0F, 0.0F};
  for (const int corner : {0, 1, 2, 3}) {
    const Vec3f ray = view_.ray(static_cast<float>(corner % 2 * view_.width),
                                static_cast<float>(corner / 2 * view_.height));
    if (!(ray.z() < 0.0F)) return {{0, 0}, {points, points}};
    const Vec3f p = on_floor(ray);
    for (const int axis : {0, 1}) {
      const float at = (p[axis] + reach_) * (cells / (2.0F * reach_));
      low[axis] = std::min(low[axis], at);
      high[axis] = std::max(high[axis], at);
    }
  }
  GridBox box;
  for (const int axis : {0, 1}) {
    box.begin[axis] =
        static_cast<std::size_t>(std::clamp(low[axis] - margin, 0.0F, static_cast<float>(cells)));
    box.end[axis] = 1 + static_cast<std::size_t>(
                            std::clamp(high[axis] + margin, 0.0F, static_cast<float>(cells)));
  }
  return box;
}

/// Computes the light of the sky on the floor, where the picture shows it, at cells + 1 points
/// along each side of a square with the side 2 reach_.
void Background::make_ambient() {
  constexpr std::size_t points = cells + 1;
  ambient_.resize(points * points);
  const float step = 2.0F * reach_ / cells;
  const GridBox box = seen_box();
  parallel_for(box.end[1] - box.begin[1], 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = box.begin[1] + begin; row < box.begin[1] + end; ++row)
      for (std::size_t column = box.begin[0]; column < box.end[0]; ++column) {
        const Vec3f p(static_cast<float>(column) * step - reach_,
                      static_cast<float>(row) * step - reach_, *ground_);
        float openness = 1.0F;
        ambient_[row * points + column] = lights_.sky(p, Vec3f::UnitZ(), openness);
      }
  });
  smooth_ambient(box);
}

/// Each direction of the sky casts a hard shadow. A small blur hides the edges.
void Background::smooth_ambient(const GridBox& box) {
  constexpr std::size_t points = cells + 1;
  const std::array<float, 3> tent = {0.25F, 0.5F, 0.25F};
  for (int pass = 0; pass < smoothing_passes; ++pass) {
    const std::size_t along = pass % 2 == 0 ? 1 : points;
    const std::vector<float> before = ambient_;
    for (std::size_t row = box.begin[1] + 1; row + 1 < box.end[1]; ++row)
      for (std::size_t column = box.begin[0] + 1; column + 1 < box.end[0]; ++column) {
        const std::size_t i = row * points + column;
        ambient_[i] =
            tent[0] * before[i - along] + tent[1] * before[i] + tent[2] * before[i + along];
      }
  }
}

float Background::ambient(const Vec3f& p) const {
  constexpr std::size_t points = cells + 1;
  const float u = (p.x() + reach_) * (cells / (2.0F * reach_));
  const float v = (p.y() + reach_) * (cells / (2.0F * reach_));
  if (!(u >= 0.0F && v >= 0.0F && u < cells && v < cells)) return 1.0F;
  const auto column = static_cast<std::size_t>(u), row = static_cast<std::size_t>(v);
  const float fu = u - static_cast<float>(column), fv = v - static_cast<float>(row);
  const float* a = ambient_.data() + row * points + column;
  const float above = a[0] + fu * (a[1] - a[0]);
  const float below = a[points] + fu * (a[points + 1] - a[points]);
  return above + fv * (below - above);
}

/// Light on the floor where the ray meets it, relative to the unshadowed floor.
float Background::shadow(const Vec3f& ray) const {
  if (ambient_.empty() || !(ray.z() < 0.0F)) return 1.0F;
  const Vec3f p = on_floor(ray);
  const float far = std::hypot(p.x(), p.y()) / reach_;
  if (!(far < 1.0F)) return 1.0F;
  const float fade = far < 0.5F ? 1.0F : 2.0F * (1.0F - far);
  constexpr float key_share = 0.45F, least = 0.12F;
  const float light = key_share * lights_.key(p, Vec3f::UnitZ()) + (1.0F - key_share) * ambient(p);
  return 1.0F - fade * (1.0F - least) * (1.0F - std::clamp(light, 0.0F, 1.0F));
}

// ---- picture -------------------------------------------------------------------------------

/// Converts linear light to 8-bit sRGB (IEC 61966-2-1), with a soft shoulder instead of a hard
/// limit.
std::uint8_t srgb(float light) {
  constexpr float knee = 0.8F;
  float c = std::max(light, 0.0F);
  if (c > knee) c = knee + (1.0F - knee) * (1.0F - std::exp((knee - c) / (1.0F - knee)));
  const float coded = c <= 0.0031308F ? 12.92F * c : 1.055F * std::pow(c, 1.0F / 2.4F) - 0.055F;
  return static_cast<std::uint8_t>(std::lrint(255.0F * std::clamp(coded, 0.0F, 1.0F)));
}

/// Colour of a pixel. Each triangle that its samples see is shaded once.
Vec3f pixel_colour(const std::int32_t* seen, int x, int row, const Shader& shader,
                   const Background& background) {
  Vec3f sum = Vec3f::Zero();
  unsigned done = 0;
  for (std::size_t s = 0; s < detail::samples; ++s) {
    if ((done >> s & 1U) != 0) continue;
    std::int32_t count = 0, middle_x = 0, middle_y = 0;
    for (std::size_t r = s; r < detail::samples; ++r) {
      if (seen[r] != seen[s]) continue;
      done |= 1U << r;
      ++count;
      middle_x += detail::sample_x[r];
      middle_y += detail::sample_y[r];
    }
    const auto n = static_cast<float>(count);
    const float px =
        static_cast<float>(x) + static_cast<float>(middle_x) / (n * detail::sub_pixels);
    const float py =
        static_cast<float>(row) + static_cast<float>(middle_y) / (n * detail::sub_pixels);
    sum += n * (seen[s] >= 0 ? shader.shade(seen[s], px, py) : background.colour(px, py));
  }
  return sum / static_cast<float>(detail::samples);
}

constexpr int band_rows = 8;

/// Indices of the screen triangles that touch each band, in order.
std::vector<std::vector<std::int32_t>> by_band(const std::vector<detail::ScreenTriangle>& triangles,
                                               int bands) {
  std::vector<std::vector<std::int32_t>> result(static_cast<std::size_t>(bands));
  constexpr int band_height = band_rows * detail::sub_pixels;
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    const auto [low, high] = std::minmax({triangles[k].y[0], triangles[k].y[1], triangles[k].y[2]});
    for (int b = low / band_height; b <= std::min(high / band_height, bands - 1); ++b)
      result[static_cast<std::size_t>(b)].push_back(static_cast<std::int32_t>(k));
  }
  return result;
}

void check_camera(const Camera& camera) {
  constexpr int largest = 16384;  // pixels; keeps sub-pixel coordinates below 2^23
  if (camera.width < 1 || camera.height < 1 || camera.width > largest || camera.height > largest)
    throw std::invalid_argument("camera: size " + std::to_string(camera.width) + "x" +
                                std::to_string(camera.height) + " is not within 1 to 16384 pixels");
  if (!(camera.field_of_view > 0.0 && camera.field_of_view < 180.0))
    throw std::invalid_argument("camera: field of view " + std::to_string(camera.field_of_view) +
                                " is not between 0 and 180 degrees");
  const Vec3 direction = camera.target - camera.eye;
  if (!direction.allFinite() || !camera.up.allFinite() || !(direction.norm() > 0.0) ||
      !(camera.up.norm() > 0.0))
    throw std::invalid_argument("camera: eye and target must be finite and differ");
}

}  // namespace

Image render(const Camera& camera, std::span<const RenderSurface> surfaces,
             const RenderConfig& config) {
  check_camera(camera);
  if (config.shadow_resolution < 8 || config.sky_directions < 0)
    throw std::invalid_argument("render: shadow resolution below 8 or negative sky directions");
  const Geometry geometry = detail::gather(surfaces);
  const View view = detail::make_view(camera, geometry.origin);
  const Lights lights(geometry, view, config);
  const Background background(geometry, view, lights, config);
  const Shader shader(surfaces, geometry, view, lights);
  const auto triangles = detail::project(view, geometry.x, geometry.triangles);
  const int bands = (camera.height + band_rows - 1) / band_rows;
  const auto band_triangles = by_band(triangles, bands);

  Image image{camera.width, camera.height, {}};
  image.rgb.resize(3 * static_cast<std::size_t>(camera.width) *
                   static_cast<std::size_t>(camera.height));
  parallel_for(static_cast<std::size_t>(bands), 1, [&](std::size_t first, std::size_t end) {
    for (std::size_t b = first; b < end; ++b) {
      const int top = static_cast<int>(b) * band_rows;
      Band band(camera.width, top, std::min(top + band_rows, camera.height));
      for (const std::int32_t k : band_triangles[b])
        detail::draw(triangles[static_cast<std::size_t>(k)], band);
      std::uint8_t* out = image.rgb.data() + 3 * static_cast<std::size_t>(top) *
                                                 static_cast<std::size_t>(camera.width);
      for (int row = band.row_begin; row < band.row_end; ++row)
        for (int x = 0; x < camera.width; ++x) {
          const Vec3f c =
              pixel_colour(band.triangle.data() + band.pixel(x, row), x, row, shader, background);
          for (int i = 0; i < 3; ++i) *out++ = srgb(c[i]);
        }
    }
  });
  return image;
}

Camera framed(Camera camera, const Vec3& low, const Vec3& high) {
  std::array<Vec3, 8> corners;
  for (std::size_t corner = 0; corner < 8; ++corner)
    for (int axis = 0; axis < 3; ++axis)
      corners[corner][axis] = (corner >> axis & 1) != 0 ? high[axis] : low[axis];
  return framed(camera, corners);
}

// In the frame of the view (right r, up u, ahead d), an eye at e sees p if |p_r - e_r| <= w (p_d -
// e_d) with the half width w of the view at distance 1: e_r - w e_d >= max(p_r - w p_d) and -e_r -
// w e_d >= max(-p_r - w p_d). The sum of both bounds e_d, their difference centres e_r.
Camera framed(Camera camera, std::span<const Vec3> points) {
  if (points.empty()) return camera;
  const Vec3 ahead = (camera.target - camera.eye).normalized();
  const Vec3 right = ahead.cross(camera.up).normalized();
  const Vec3 up = right.cross(ahead);
  constexpr double margin = 1.04, smallest = 1e-6;
  const double tall = std::tan(camera.field_of_view * std::numbers::pi / 360.0) / margin;
  const std::array<Vec3, 2> axes = {right, up};
  const std::array<double, 2> half = {tall * camera.width / camera.height, tall};
  std::array<double, 2> across{};
  double eye = std::numeric_limits<double>::infinity();
  double middle = 0.0;
  for (const Vec3& p : points) middle += p.dot(ahead) / static_cast<double>(points.size());
  for (std::size_t k = 0; k < 2; ++k) {
    double most = -std::numeric_limits<double>::infinity(), least = most;
    for (const Vec3& p : points) {
      const double depth = half[k] * p.dot(ahead);
      most = std::max(most, p.dot(axes[k]) - depth);
      least = std::max(least, -p.dot(axes[k]) - depth);
    }
    across[k] = 0.5 * (most - least);
    eye = std::min(eye, -0.5 * (most + least) / half[k]);
  }
  middle = std::max(middle, eye + smallest);
  const Vec3 side = across[0] * right + across[1] * up;
  camera.eye = side + eye * ahead;
  camera.target = side + middle * ahead;
  return camera;
}

}  // namespace selvedge
