// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/types.h>

#include <cstdint>
#include <filesystem>
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

/// Writes to a temporary file beside the target and renames it. Throws std::runtime_error that
/// names the file and the cause.
void write_png(const std::filesystem::path& file, const Image& image);

/// True if ffmpeg is on PATH, so that animations can be written.
bool ffmpeg_is_there();

/// Passes pictures one by one to ffmpeg, which encodes them as .mp4 (H.264), .webm (VP9) or .gif.
/// The video formats require even sides, so odd sides are padded there by a row or column. The file
/// appears under its name only after finish() has succeeded.
class AnimationWriter {
 public:
  /// `fps` is in frames per second. Throws std::invalid_argument if the extension is unknown, if
  /// the rate is not in (0, 1000], or if ffmpeg is missing.
  AnimationWriter(std::filesystem::path file, double fps);
  ~AnimationWriter();
  AnimationWriter(const AnimationWriter&) = delete;
  AnimationWriter& operator=(const AnimationWriter&) = delete;

  /// The first call starts ffmpeg. Throws std::invalid_argument if the size differs from that of
  /// the first picture, std::runtime_error if ffmpeg cannot be started or has stopped.
  void add(const Image& image);
  /// Throws std::runtime_error if there is no picture, if ffmpeg fails, or if the file cannot be
  /// renamed. ffmpeg writes its own message to standard error.
  void finish();

 private:
  void start(int width, int height);
  int wait();

  std::filesystem::path file_, partial_;
  double fps_;
  int width_ = 0, height_ = 0;
  int socket_ = -1;
  int process_ = -1;
};

}  // namespace selvedge
