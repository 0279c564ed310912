// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/render.h>

#include <filesystem>

namespace selvedge {

/// Whether an animation can be written here: ffmpeg is on PATH.
bool ffmpeg_is_there();

/// Pictures handed one by one to ffmpeg, which makes an .mp4 (H.264), .webm (VP9) or .gif of them.
/// Pictures with an odd side are padded by a row or column, as the video formats demand. The file
/// appears under its name when finish() has succeeded.
class AnimationWriter {
 public:
  /// Throws std::invalid_argument for another extension, a rate that is not > 0, or where ffmpeg is
  /// missing; std::runtime_error if it cannot be started.
  AnimationWriter(std::filesystem::path file, double fps);
  ~AnimationWriter();
  AnimationWriter(const AnimationWriter&) = delete;
  AnimationWriter& operator=(const AnimationWriter&) = delete;

  /// Throws std::invalid_argument for a picture of another size than the first.
  void add(const Image& image);
  /// Throws std::runtime_error if ffmpeg fails; its own message is on standard error.
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
