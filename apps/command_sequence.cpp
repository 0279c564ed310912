// SPDX-License-Identifier: MIT
#include "command_sequence.h"

#include <fmt/format.h>
#include <selvedge/bodies/animation_file.h>
#include <selvedge/run/result_folder.h>

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

namespace {

using namespace selvedge;
namespace fs = std::filesystem;

struct SequenceOptions {
  std::string file, out, base, up;
  double fps = 30.0, unit = 1.0;
  bool no_weld = false;
};

/// glTF has y up by its specification; a USD stage says it itself.
UpAxis up_axis_of(const SequenceOptions& o) {
  const std::string extension = fs::path(o.file).extension().string();
  const bool y_by_default = extension == ".glb" || extension == ".gltf";
  const std::string up = !o.up.empty() ? o.up : y_by_default ? "y" : "z";
  return up == "x" ? UpAxis::x : up == "y" ? UpAxis::y : UpAxis::z;
}

int sequence_command(const SequenceOptions& o) {
  const AnimationConfig config{.fps = o.fps,
                               .base = o.base,
                               .load = {.unit = o.unit, .up = up_axis_of(o), .weld = !o.no_weld}};
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
  fmt::print("{} frames of {} vertices and {} triangles in {}\n", frames,
             animation.frames.front().size(), animation.triangles.size(), out.string());
  if (frames == 1)
    fmt::print("the file has no animation: {{\"mesh\": \"{}\"}}\n",
               numbered(out, "body", 0, kFrameFileDigits, ".ply").string());
  else
    fmt::print("an obstacle of a scene: {{\"sequence\": {{\"files\": \"{}\", \"fps\": {}}}}}\n",
               (out / "body_#####.ply").string(), animation.fps > 0.0 ? animation.fps : o.fps);
  return 0;
}

}  // namespace

void add_command_sequence(const Command& app) {
  const auto options = std::make_shared<SequenceOptions>();
  const Command command = app.subcommand(
      "sequence", "Bake an animated mesh to numbered files, for obstacles of scenes");
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
  command.option("--unit", options->unit, "Metres per unit of the file").range(1e-9, 1e9);
  command
      .option("--up", options->up, "Axis of the file that points up (default: y for glTF, else z)")
      .one_of({"x", "y", "z"});
  command.flag("--no-weld", options->no_weld,
               "Keep vertices apart that are at the same place in every frame");
  command.action([options] { return sequence_command(*options); });
}
