// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace selvedge {

/// 8-bit RGB, row by row from the top.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

struct Camera {
  Vec3 eye = Vec3(1.6, -2.2, 1.4), target = Vec3(0.0, 0.0, 0.3), up = Vec3::UnitZ();   ///< m
  double field_of_view = 35.0;   ///< degrees, vertical
  int width = 960, height = 720;
};

struct RenderSurface {
  std::span<const Vec3> x;
  std::span<const Triangle> triangles;
  Vec3 front = Vec3(0.75, 0.25, 0.22), back = Vec3(0.85, 0.72, 0.42);   ///< linear RGB in [0,1]
  bool smooth = true;            ///< interpolate vertex normals
};

/// Software rasteriser: two-sided shading, antialiased, soft shadows from a shadow map, needs no
/// display. Deterministic for any thread count.
Image render(const Camera& camera, std::span<const RenderSurface> surfaces);

/// Throws std::runtime_error with file and cause.
void write_png(const std::filesystem::path& file, const Image& image);

}  // namespace selvedge
