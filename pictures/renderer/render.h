// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace selvedge {

/// 8-bit sRGB image, stored row by row from the top.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

struct Camera {
  Vec3 eye = Vec3(1.6, -2.2, 1.4), target = Vec3(0.0, 0.0, 0.3), up = Vec3::UnitZ();  ///< m
  double field_of_view = 35.0;  ///< degrees, vertical
  int width = 960, height = 720;
};

struct RenderSurface {
  std::span<const Vec3> x;
  std::span<const Triangle> triangles;
  Vec3 front = Vec3(0.50, 0.085, 0.065), back = Vec3(0.72, 0.52, 0.24);  ///< linear RGB in [0,1]
  double crease = 180.0;  ///< degrees; edges sharper than this stay sharp (0: every face is flat)
  double sheen = 0.0;     ///< brightens the silhouette, as fibres do; 0: off, 1: velvet
  /// Position of each vertex in the flat cloth, m: one per vertex of x, or empty. If given, a grid
  /// of lines with the spacing `grid` is drawn into the cloth.
  std::span<const Eigen::Vector2d> material = {};
  double grid = 0.05;  ///< m
  /// True for a part of the surroundings, such as a floor. The lights and the automatic framing do
  /// not aim at it.
  bool backdrop = false;
};

struct RenderConfig {
  bool ground = true;  ///< draws a plane that shows only shadows, unless the eye is below it
  double ground_z = std::numeric_limits<double>::quiet_NaN();  ///< m; NaN: lowest vertex
  int shadow_resolution = 1536;  ///< texels of the key light's shadow map along a side
  int sky_directions = 48;       ///< more directions: smoother ambient shadows, more time
};

/// Software rasteriser with two-sided shading, antialiasing, and soft shadows of a key light and of
/// the sky. It needs no display. The image is the same for any number of threads. Throws
/// std::invalid_argument if the camera has no direction or no size, or if a mesh has an invalid
/// index or coordinate.
Image render(const Camera& camera, std::span<const RenderSurface> surfaces,
             const RenderConfig& config = {});

/// Returns `camera` with its eye and target moved so that the box from `low` to `high` just fits
/// the picture. The direction of view stays the same.
Camera framed(Camera camera, const Vec3& low, const Vec3& high);
/// The same for points: some of them are next to two opposite edges of the picture.
Camera framed(Camera camera, std::span<const Vec3> points);

}  // namespace selvedge
