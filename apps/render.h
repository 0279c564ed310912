// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <vector>

namespace selvedge {

/// 8-bit sRGB, row by row from the top.
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
  double sheen = 0.0;     ///< light along the silhouette, as of fibres; 0: none, 1: velvet
  /// Position of each vertex in the flat cloth, m, one per vertex of x, or empty. With it a grid of
  /// lines every `grid` metres is drawn into the cloth.
  std::span<const Eigen::Vector2d> material = {};
  double grid = 0.05;  ///< m
  /// Part of the surroundings (a floor): light and automatic framing do not aim at it.
  bool backdrop = false;
};

struct RenderConfig {
  bool ground = true;  ///< a plane that shows nothing but shadows, unless the eye is below it
  double ground_z = std::numeric_limits<double>::quiet_NaN();  ///< m; not a number: lowest vertex
  int shadow_resolution = 1536;  ///< texels of the key light's shadow map along a side
  int sky_directions = 48;       ///< more: smoother ambient shadows, in proportion slower
};

/// Software rasteriser: two-sided shading, antialiased, soft shadows of a key light and of the sky,
/// needs no display. Deterministic for any thread count. Throws std::invalid_argument for a camera
/// without direction or size and for a mesh with a broken index or coordinate.
Image render(const Camera& camera, std::span<const RenderSurface> surfaces,
             const RenderConfig& config = {});

/// `camera` with its eye and target moved, along its present direction of view, so that the box
/// from `low` to `high` just fits the picture.
Camera framed(Camera camera, const Vec3& low, const Vec3& high);

/// Throws std::runtime_error with file and cause. Written beside the target and renamed.
void write_png(const std::filesystem::path& file, const Image& image);

}  // namespace selvedge
