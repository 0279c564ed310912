// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/processes.h>
#include <selvedge/pictures/picture_files.h>

#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace selvedge {
namespace {

constexpr const char* pad_to_even = "pad=ceil(iw/2)*2:ceil(ih/2)*2";

/// Output options of ffmpeg for a file extension; empty if the extension is unknown.
std::vector<std::string> encoding(const std::string& extension) {
  if (extension == ".mp4")
    return {"-vf",      pad_to_even, "-c:v",      "libx264",    "-crf", "18",
            "-pix_fmt", "yuv420p",   "-movflags", "+faststart", "-f",   "mp4"};
  if (extension == ".webm")
    return {"-vf",  pad_to_even, "-c:v",     "libvpx-vp9", "-crf", "28",
            "-b:v", "0",         "-pix_fmt", "yuv420p",    "-f",   "webm"};
  if (extension == ".gif")
    return {"-vf", "split[a][b];[a]palettegen[p];[b][p]paletteuse=dither=sierra2_4a", "-f", "gif"};
  return {};
}

std::string text(double value) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << value;
  return out.str();
}

}  // namespace

bool ffmpeg_is_there() { return program_is_there("ffmpeg"); }

AnimationWriter::AnimationWriter(std::filesystem::path file, double fps)
    : file_(std::move(file)), partial_(file_), fps_(fps) {
  partial_ += ".partial";
  if (encoding(file_.extension().string()).empty())
    throw std::invalid_argument(file_.string() + ": an animation ends in .mp4, .webm or .gif");
  if (!(fps_ > 0.0 && fps_ <= 1000.0))
    throw std::invalid_argument(file_.string() + ": " + text(fps_) +
                                " frames per second are not within 0 and 1000");
  if (!ffmpeg_is_there())
    throw std::invalid_argument(file_.string() +
                                ": ffmpeg is not on PATH; install it (apt install ffmpeg) or make "
                                "the animation from the pictures elsewhere");
}

AnimationWriter::~AnimationWriter() {
  if (!ffmpeg_) return;
  ffmpeg_.reset();
  std::error_code ignored;  // a destructor cannot report that the file remains
  std::filesystem::remove(partial_, ignored);
}

void AnimationWriter::start(int width, int height) {
  width_ = width;
  height_ = height;
  // With the prefix `file:`, ffmpeg treats the name as a file even if it looks like an option or a
  // protocol.
  std::vector<std::string> words = {
      "ffmpeg",    "-y",
      "-loglevel", "error",
      "-f",        "rawvideo",
      "-pix_fmt",  "rgb24",
      "-s",        std::to_string(width) + "x" + std::to_string(height),
      "-r",        text(fps_),
      "-i",        "pipe:0"};
  for (const std::string& word : encoding(file_.extension().string())) words.push_back(word);
  words.push_back("file:" + partial_.string());
  try {
    ffmpeg_ = std::make_unique<FedProgram>(words);
  } catch (const std::system_error& error) {
    throw std::runtime_error("cannot start ffmpeg: " + error.code().message());
  }
}

void AnimationWriter::add(const Image& image) {
  if (!ffmpeg_) start(image.width, image.height);
  if (image.width != width_ || image.height != height_)
    throw std::invalid_argument(file_.string() + ": pictures of different sizes");
  if (!ffmpeg_->write(image.rgb.data(), image.rgb.size()))
    throw std::runtime_error(file_.string() + ": ffmpeg stopped before the end");
}

void AnimationWriter::finish() {
  if (!ffmpeg_) throw std::runtime_error(file_.string() + ": an animation without a picture");
  const ProcessEnd end = std::exchange(ffmpeg_, nullptr)->finish();
  const bool done = !end.by_signal && end.code == 0;
  std::error_code error;
  if (done) std::filesystem::rename(partial_, file_, error);
  if (done && !error) return;
  const std::string cause = error ? error.message() : "ffmpeg failed; its message stands above";
  std::filesystem::remove(partial_, error);
  throw std::runtime_error("cannot write " + file_.string() + ": " + cause);
}

}  // namespace selvedge
