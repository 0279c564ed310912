// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/option_values.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/apps/detail/progress_bar.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/pictures/picture_files.h>
#include <selvedge/pictures/renderer/render.h>
#include <selvedge/pictures/result_pictures.h>
#include <selvedge/run/result_folder.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace selvedge;

struct RenderOptions {
  std::string result, out, frames, size, eye, target, animation;
  int turntable = 0;
};

// ---- values of options ---------------------------------------------------------------------

std::optional<Vec3> point(const std::string& option, const std::string& value) {
  if (value.empty()) return std::nullopt;
  const auto pieces = split(value, ',');
  Vec3 result;
  for (int i = 0; i < 3; ++i) {
    const auto coordinate = pieces.size() == 3
                                ? number_from<double>(pieces[static_cast<std::size_t>(i)])
                                : std::nullopt;
    if (!coordinate || !std::isfinite(*coordinate))
      refuse_value(option, value, "must be three numbers, x,y,z in metres");
    result[i] = *coordinate;
  }
  return result;
}

void read_size(const std::string& value, CameraChoice& camera) {
  if (value.empty()) return;
  const auto pieces = split(value, 'x');
  const auto width = number_from<int>(pieces.front());
  const auto height = pieces.size() == 2 ? number_from<int>(pieces.back()) : std::nullopt;
  constexpr int largest = 16384;
  if (!width || !height || std::min(*width, *height) < 1 || std::max(*width, *height) > largest)
    refuse_value("--size", value, "must be WIDTHxHEIGHT in pixels, each 1 to 16384");
  camera.width = *width;
  camera.height = *height;
}

// ---- the pictures --------------------------------------------------------------------------

struct Shot {
  int frame;
  Camera camera;
  std::filesystem::path file;
};

/// The camera turned about the upright axis through its target.
Camera turned(Camera camera, double turn) {
  const Eigen::AngleAxisd rotation(turn, Vec3::UnitZ());
  camera.eye = camera.target + rotation * (camera.eye - camera.target);
  camera.up = rotation * camera.up;
  return camera;
}

std::vector<Shot> shots(const RenderOptions& options, ResultPictures& pictures,
                        const std::filesystem::path& out) {
  CameraChoice choice;
  choice.eye = point("--eye", options.eye);
  choice.target = point("--target", options.target);
  read_size(options.size, choice);
  const bool all = !options.animation.empty() && options.turntable == 0;
  const std::vector<int> frames = !options.frames.empty()
                                      ? chosen_frames(options.frames, pictures.frames())
                                  : all ? pictures.frames()
                                        : std::vector<int>{pictures.frames().back()};
  const Camera camera = pictures.camera(choice, frames);
  std::vector<Shot> result;
  if (options.turntable > 0)
    for (int i = 0; i < options.turntable; ++i)
      result.push_back({frames.back(),
                        turned(camera, 2.0 * std::numbers::pi * i / options.turntable),
                        numbered(out, "turntable", i, 4, ".png")});
  else if (!pictures.is_folder())
    result.push_back({frames.back(), camera,
                      out / (std::filesystem::path(options.result).stem().string() + ".png")});
  else
    for (const int frame : frames)
      result.push_back({frame, camera, numbered(out, "frame", frame, 5, ".png")});
  return result;
}

/// Frames per second at which the shots show the motion at its true speed; turntables turn in the
/// time that 30 pictures a second take.
double playing_rate(const RenderOptions& options, const ResultPictures& pictures,
                    const std::vector<Shot>& list) {
  constexpr double turntable_fps = 30.0;
  if (options.turntable > 0) return turntable_fps;
  if (list.size() < 2) return pictures.fps();
  return pictures.fps() * static_cast<double>(list.size() - 1) /
         (list.back().frame - list.front().frame);
}

std::filesystem::path picture_folder(const RenderOptions& options, const ResultPictures& pictures) {
  if (!options.out.empty()) return options.out;
  return pictures.is_folder() ? std::filesystem::path(options.result) / "pictures"
                              : std::filesystem::path(".");
}

int render_command(const RenderOptions& options) {
  ResultPictures pictures(options.result);
  const auto out = picture_folder(options, pictures);
  const std::vector<Shot> list = shots(options, pictures, out);
  std::error_code error;
  std::filesystem::create_directories(out, error);
  if (error) throw std::invalid_argument(out.string() + ": cannot be made: " + error.message());

  // Without ffmpeg the pictures are drawn all the same, and only then is its absence an error.
  std::optional<AnimationWriter> animation;
  const bool animated = !options.animation.empty();
  const double fps = playing_rate(options, pictures, list);
  if (animated && ffmpeg_is_there()) animation.emplace(options.animation, fps);
  ProgressBar bar("picture", static_cast<int>(list.size()));
  const Stopwatch watch;
  for (std::size_t i = 0; i < list.size(); ++i) {
    bar.show(static_cast<int>(i), watch.seconds());
    const Image image = pictures.picture(list[i].frame, list[i].camera);
    write_png(list[i].file, image);
    if (animation) animation->add(image);
  }
  bar.clear();
  print_escaped("{} in {}\n",
                list.size() == 1 ? list.front().file.filename().string()
                                 : fmt::format("{} pictures", list.size()),
                out.string());
  if (!animated) return 0;
  if (!animation) animation.emplace(options.animation, fps);
  animation->finish();
  print_escaped("{}\n", options.animation);
  return 0;
}

void add_render_options(const Command& command) {
  const auto options = std::make_shared<RenderOptions>();
  command.option("result", options->result, "Result folder of a run, or a mesh file").required();
  command.option("--out", options->out,
                 "Folder for the pictures (default: pictures/ of the result)");
  command.option("--frames", options->frames, "FIRST:LAST:STEP or one number (default: the last)");
  command.option("--size", options->size, "WIDTHxHEIGHT of the pictures");
  command.option("--eye", options->eye, "Position of the camera, x,y,z in metres");
  command.option("--target", options->target, "Point that the camera looks at, x,y,z in metres");
  command
      .option("--turntable", options->turntable,
              "This many views around the last of the chosen frames")
      .range(1, 10000);
  command.option("--animation", options->animation,
                 "Also encode the pictures as an animation with ffmpeg: .mp4, .webm or "
                 ".gif");
  command.action([options] { return render_command(*options); });
}

}  // namespace

selvedge::ProgramCommand render_command() {
  return {.name = "render",
          .purpose = "Draw pictures of a result folder or a mesh file",
          .add_options = add_render_options};
}
