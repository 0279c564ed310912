// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

inline constexpr int kLeastResolution = 16, kMostResolution = 4096;
/// The box of the drawn surface fills this fraction of the range of the depth buffer, so that
/// rounding clips nothing.
inline constexpr double kDepthRange = 1.0 - 0x1p-20;

/// Returns `resolution` if it is within the limits; otherwise throws std::invalid_argument.
int checked_resolution(int resolution, const std::string& who);

/// The directions of an orthographic picture, orthonormal; `toward` points to the viewer of the
/// front.
struct MapAxes {
  Vec3 right, up, toward;
};

/// Position and scale of an orthographic picture. Texels are square.
struct MapFrame {
  MapAxes axes;
  Vec3 center = Vec3::Zero();  ///< m, of the drawn box
  Vec3 half = Vec3::Zero();    ///< m, half its extents along right, up and toward, without a margin
  double texel = 1.0;          ///< m
  int width = 0, height = 0;   ///< texels

  /// Position in texels from the lower left corner, and metres above the centre.
  Vec3 place(const Vec3& x) const {
    const Vec3 d = x - center;
    return {axes.right.dot(d) / texel + 0.5 * width, axes.up.dot(d) / texel + 0.5 * height,
            axes.toward.dot(d)};
  }
};

/// The smallest frame around the vertices of `triangles`, with `resolution` texels along its longer
/// side. Throws std::invalid_argument if its size is not finite.
MapFrame frame_around(std::span<const Vec3> x, std::span<const Triangle> triangles,
                      const MapAxes& axes, int resolution, const std::string& name);

/// One picture, row by row from the bottom. Depth is in units of half[2] / kDepthRange of the
/// frame.
struct Layer {
  std::vector<std::int32_t> triangle;       ///< -1: nothing
  std::vector<float> normal_depth, motion;  ///< four each; empty if not requested
};

/// Values per vertex that the picture interpolates; empty: pictures of indices only.
struct VertexColours {
  std::span<const Vec3> normal, motion;
};

/// Draws orthographic pictures of a triangle mesh into memory, by llvmpipe of OSMesa with
/// single-precision depth. A triangle is visible where it covers the middle of a texel. The same
/// input gives the same bytes. Any thread may use it, one at a time.
class OffscreenRenderer {
 public:
  /// Throws std::runtime_error that says what is missing.
  OffscreenRenderer();
  ~OffscreenRenderer();
  OffscreenRenderer(const OffscreenRenderer&) = delete;
  OffscreenRenderer& operator=(const OffscreenRenderer&) = delete;

  /// Draws the two outermost layers of one view. A triangle with equal corners is not drawn but
  /// keeps its index.
  void draw(const MapFrame& frame, std::span<const Vec3> x, std::span<const Triangle> triangles,
            const VertexColours& colours, Layer& front, Layer& back);

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace selvedge::detail
