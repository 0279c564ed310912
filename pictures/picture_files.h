// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/pictures/renderer/render.h>

#include <filesystem>
#include <memory>

namespace selvedge {

class FedProgram;

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

  std::filesystem::path file_, partial_;
  double fps_;
  int width_ = 0, height_ = 0;
  std::unique_ptr<FedProgram> ffmpeg_;
};

}  // namespace selvedge
