// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/render.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::raster {

using Vec3f = Eigen::Vector3f;

/// Camera of the picture in single precision, about an origin near the scene.
struct View {
  Vec3f eye, right, up, forward;
  float focal = 1.0F;    ///< pixels
  float nearest = 0.0F;  ///< m, depth of the near plane
  int width = 0, height = 0;

  /// Direction with depth 1 through a point of the picture, in pixels from the top left corner.
  Vec3f ray(float x, float y) const;
};

View make_view(const Camera& camera, const Vec3& origin);

constexpr int sub_pixels = 256;  ///< vertices are snapped to 1/256 pixel, edges are then exact
constexpr int samples = 8;       ///< per pixel, at fixed places
/// Places of the samples in a pixel, in sub-pixels: one in each of eight columns and rows.
extern const std::array<std::int32_t, samples> sample_x, sample_y;

/// A triangle inside the view, in sub-pixels. 1/depth is linear on the picture: depth_a at the
/// first corner, and its slope per pixel.
struct ScreenTriangle {
  std::array<std::int32_t, 3> x, y;  ///< counter-clockwise in a frame with y downwards: area > 0
  float depth_dx, depth_dy, depth_a;
  std::int32_t triangle;
};

/// The parts of all triangles that lie in the view, in the order of the triangles.
std::vector<ScreenTriangle> project(const View& view, std::span<const Vec3f> x,
                                    std::span<const Triangle> triangles);

/// A horizontal band of the picture: what each sample sees.
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

/// A sample belongs to a triangle if its place lies inside, or on a top or left edge: triangles
/// that share an edge leave no gap and draw no sample twice. The nearer one wins, the first of
/// equals.
void draw(const ScreenTriangle& triangle, Band& band);

}  // namespace selvedge::raster
