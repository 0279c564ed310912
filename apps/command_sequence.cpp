// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/option_values.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/bodies/internal/animation_file.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/run/result_folder.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

namespace {

using namespace selvedge;
namespace fs = std::filesystem;

struct SequenceOptions {
  std::string file, out, base, up;
  double fps = 30.0;
  std::optional<double> unit;
};

int sequence_command(const SequenceOptions& o) {
  const AnimationConfig config{
      .fps = o.fps, .base = o.base, .load = {.unit = o.unit, .up = up_axis(o.up)}};
  const MeshAnimation animation = load_animation(o.file, config);
  const std::string stem = fs::path(o.file).stem().string();
  const fs::path out = o.out.empty() ? fs::path(stem) : fs::path(o.out);
  std::error_code error;
  fs::create_directories(out, error);
  if (error) throw std::invalid_argument(out.string() + ": cannot be made: " + error.message());
  const int frames = static_cast<int>(animation.frames.size());
  for (int i = 0; i < frames; ++i)
    write_ply(numbered(out, "body", i, kFrameFileDigits, ".ply"),
              animation.frames[static_cast<std::size_t>(i)], animation.triangles);
  print_escaped("{} of {} and {} in {}\n", counted(frames, "frame"),
                counted(animation.frames.front().size(), "vertex", "vertices"),
                counted(animation.triangles.size(), "triangle"), out.string());
  if (frames == 1)
    print_escaped("the file has no animation: {{\"mesh\": \"{}\"}}\n",
                  numbered(out, "body", 0, kFrameFileDigits, ".ply").string());
  else
    print_escaped("an obstacle of a scene: {{\"sequence\": {{\"files\": \"{}\", \"fps\": {}}}}}\n",
                  (out / "body_#####.ply").string(), animation.fps > 0.0 ? animation.fps : o.fps);
  return 0;
}

void add_sequence_options(const Command& command) {
  const auto options = std::make_shared<SequenceOptions>();
  command
      .option("file", options->file,
              "glTF, FBX, Collada or another file that assimp reads; .usda; .pc2 or .mdd")
      .required();
  command.option("--out", options->out, "Folder for the files (default: the name of the file)");
  command.option("--base", options->base, "Mesh with the triangles of a .pc2 or .mdd cache");
  command
      .option("--fps", options->fps,
              "Frames per second at which skeletons and keyframes are sampled")
      .range(0.01, 1000.0)
      .show_default();
  command
      .option("--unit", options->unit,
              "Metres per unit of the file (default: what it states, else 1)")
      .range(1e-9, 1e9);
  command
      .option("--up", options->up,
              "Axis of the file that points up (default: what it states, else z)")
      .one_of({"x", "y", "z"});
  command.action([options] { return sequence_command(*options); });
}

}  // namespace

selvedge::ProgramCommand sequence_command() {
  return {.name = "sequence",
          .purpose = "Bake an animated mesh to numbered files, for obstacles of scenes",
          .add_options = add_sequence_options};
}
