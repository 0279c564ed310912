// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/run/detail/checkpoint.h>
#include <selvedge/run/detail/frame_output.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/scene/scene.h>

#include <stdexcept>
#include <utility>

namespace selvedge::detail {

namespace fs = std::filesystem;

namespace {

MethodOptions options_of(const OutputSpec& output, const std::string& name) {
  const auto found = output.format_options.find(name);
  return found == output.format_options.end() ? MethodOptions{} : found->second;
}

/// Bodies at rest are written once, with state 0.
bool bodies_due(const Simulation& simulation, int number) {
  return number == 0 || simulation.bodies_move();
}

}  // namespace

FrameOutput::FrameOutput(const Scene& scene, const FrameFormatRegistry& formats, fs::path out,
                         bool mesh_changes)
    : out_(std::move(out)),
      fps_(scene.time.fps),
      ply_(make_ply_writer(out_ / "frames", kFrameFileDigits)),
      steps_(make_ply_writer(out_ / "steps", kStepFileDigits)) {
  for (const std::string& name : scene.output.all_formats()) {
    auto writer =
        make_method(formats, name, "output.formats", options_of(scene.output, name), out_);
    if (mesh_changes && formats.at(name).traits().one_mesh)
      throw std::invalid_argument(
          fmt::format("output: \"refine\" changes the mesh, but a {} file holds one mesh; take "
                      "another format, such as vtk",
                      name));
    if (name != "ply") others_.push_back(std::move(writer));
  }
}

Frame FrameOutput::frame_of(const Simulation& simulation, int number) const {
  const SimulationState& state = simulation.state();
  Frame frame;
  frame.number = number;
  frame.time = number / fps_;
  frame.x = state.x;
  frame.v = state.v;
  frame.triangles = simulation.cloth_triangles();
  if (bodies_due(simulation, number)) frame.bodies = simulation.body_positions();
  frame.body_triangles = simulation.body_triangles();
  return frame;
}

void FrameOutput::write_frame(const Simulation& simulation, int number) {
  const std::vector<NamedValues> values = frame_values(simulation);
  Frame frame = frame_of(simulation, number);
  frame.values = values;
  ply_->write(frame);
  for (const auto& writer : others_) {
    writer->write(frame);
    writer->update_series();
  }
}

void FrameOutput::write_step(const Simulation& simulation, int number) {
  const std::vector<NamedValues> values = frame_values(simulation);
  Frame frame = frame_of(simulation, number);
  frame.time = simulation.state().time;
  frame.values = values;
  steps_->write(frame);
}

void FrameOutput::resume(const Simulation& simulation, int last) {
  if (others_.empty()) return;
  const bool has_bodies = !simulation.body_positions().empty();
  for (int number = 0; number <= last; ++number) {
    const auto file = [&](const char* stem) {
      return numbered(out_ / "frames", stem, number, kFrameFileDigits, ".ply");
    };
    std::vector<NamedValues> values;
    const TriangleMesh cloth = read_ply(file("cloth"), values);
    const std::vector<Vec3> v = velocities(values, file("cloth"));
    TriangleMesh bodies;
    if (has_bodies && bodies_due(simulation, number)) bodies = read_mesh(file("bodies"));
    const Frame frame = {.number = number,
                         .time = number / fps_,
                         .x = cloth.vertices,
                         .v = v,
                         .triangles = cloth.triangles,
                         .values = values,
                         .bodies = bodies.vertices,
                         .body_triangles = bodies.triangles};
    for (const auto& writer : others_) writer->write(frame);
  }
  for (const auto& writer : others_) writer->update_series();
}

}  // namespace selvedge::detail
