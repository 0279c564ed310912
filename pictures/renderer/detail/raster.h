// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/pictures/renderer/render.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

using Vec3f = Eigen::Vector3f;

/// Camera of the picture in single precision, relative to an origin near the scene.
struct View {
  Vec3f eye, right, up, forward;
  float focal = 1.0F;    ///< pixels
  float nearest = 0.0F;  ///< m, depth of the near plane
  int width = 0, height = 0;

  /// Direction with depth 1 through a point of the picture, given in pixels from the top left
  /// corner.
  Vec3f ray(float x, float y) const;
};

View make_view(const Camera& camera, const Vec3& origin);

constexpr int sub_pixels = 256;  ///< vertices snap to 1/256 pixel, so edge tests are exact
constexpr int samples = 8;       ///< per pixel, at fixed positions
/// Positions of the samples in a pixel, in sub-pixels: one sample in each of eight columns and
/// rows.
extern const std::array<std::int32_t, samples> sample_x, sample_y;

/// A triangle inside the view, in sub-pixels. 1/depth is linear on the picture: its value at the
/// first corner is depth_a, its slopes per pixel are depth_dx and depth_dy.
struct ScreenTriangle {
  std::array<std::int32_t, 3> x, y;  ///< counter-clockwise in a frame with y downwards: area > 0
  float depth_dx, depth_dy, depth_a;
  std::int32_t triangle;
};

/// Clips all triangles to the view and projects them. The order of the triangles is kept.
std::vector<ScreenTriangle> project(const View& view, std::span<const Vec3f> x,
                                    std::span<const Triangle> triangles);

/// A horizontal band of the picture, with the triangle and the depth that each sample sees.
struct Band {
  int width = 0, row_begin = 0, row_end = 0;
  std::vector<float> inverse_depth;    ///< 0: nothing
  std::vector<std::int32_t> triangle;  ///< -1: nothing

  Band(int picture_width, int begin, int end);
  std::size_t pixel(int x, int row) const {
    return static_cast<std::size_t>(samples) *
           (static_cast<std::size_t>(row - row_begin) * static_cast<std::size_t>(width) +
            static_cast<std::size_t>(x));
  }
};

/// A sample belongs to a triangle if it lies inside, or on a top or left edge, so triangles that
/// share an edge leave no gap and draw no sample twice. The nearest triangle wins; of equally near
/// ones, the first.
void draw(const ScreenTriangle& triangle, Band& band);

}  // namespace selvedge::detail
