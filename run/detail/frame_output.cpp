// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/run/detail/frame_output.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/step_report.h>

#include <cmath>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace selvedge::detail {

namespace fs = std::filesystem;

namespace {

MethodOptions options_of(const OutputSpec& output, const std::string& name) {
  const auto found = output.format_options.find(name);
  return found == output.format_options.end() ? MethodOptions{} : found->second;
}

Frame frame_of(const StateCopy& copy, const std::vector<NamedValues>& values) {
  return {.number = copy.number,
          .time = copy.time,
          .x = copy.state.x,
          .v = copy.state.v,
          .triangles = copy.triangles,
          .values = values,
          .bodies = copy.bodies,
          .body_triangles = copy.body_triangles};
}

/// The option of the format ply.
bool wants_pressure(const OutputSpec& output) {
  const MethodOptions options = options_of(output, "ply");
  return options.contains("pressure") && options.flag("pressure");
}

/// Pressure of the contacts of the last step on each cloth vertex, Pa: the normal impulses over the
/// length of the step and a third of the area of the triangles at the vertex.
std::vector<double> contact_pressure(const Simulation& simulation) {
  const auto x = simulation.positions();
  std::vector<double> pressure(x.size(), 0.0);
  const std::vector<double>& lengths = simulation.last_step().lengths;
  if (lengths.empty()) return pressure;
  for (const StepContact& c : simulation.contacts()) {
    const double impulse = c.impulse.dot(c.point.normal);
    for (std::size_t k = 0; k < c.point.vertex.size(); ++k)
      if (const auto v = static_cast<std::size_t>(c.point.vertex[k]); v < x.size())
        pressure[v] += std::abs(c.point.weight[k]) * impulse;
  }
  const std::vector<double> areas = vertex_areas(x, simulation.cloth_triangles());
  for (std::size_t v = 0; v < pressure.size(); ++v)
    pressure[v] = areas[v] > 0.0 ? pressure[v] / (areas[v] * lengths.back()) : 0.0;
  return pressure;
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
      pressure_(wants_pressure(scene.output)),
      ply_(make_ply_writer(out_ / "frames", kFrameFileDigits)),
      steps_(make_ply_writer(out_ / "steps", kStepFileDigits)) {
  for (const std::string& name : scene.output.all_formats()) {
    auto writer =
        make_method(formats, name, "output.formats", options_of(scene.output, name), out_);
    if (mesh_changes && formats.at(name).traits().one_mesh)
      throw std::invalid_argument(fmt::format(
          "output: \"refine\" or \"merge\" changes the mesh, but a {} file holds one mesh; take "
          "another format, such as vtk",
          name));
    if (name != "ply") others_.push_back(std::move(writer));
  }
}

StateCopy FrameOutput::copy_frame(const Simulation& simulation, int number) const {
  return {
      .number = number,
      .time = number / fps_,
      .state = simulation.state(),
      .flags = simulation.flags(),
      .pressure = pressure_ ? contact_pressure(simulation) : std::vector<double>(),
      .bodies = bodies_due(simulation, number) ? simulation.body_positions() : std::vector<Vec3>(),
      .triangles = simulation.cloth_triangles(),
      .body_triangles = simulation.body_triangles(),
      .owner = simulation.owner()};
}

void FrameOutput::write_frame(const StateCopy& copy) {
  const std::vector<NamedValues> values = frame_values(copy);
  const Frame frame = frame_of(copy, values);
  ply_->write(frame);
  for (const auto& writer : others_) {
    writer->write(frame);
    writer->update_series();
  }
}

void FrameOutput::write_step(const Simulation& simulation, int number) {
  StateCopy copy = copy_frame(simulation, number);
  copy.time = copy.state.time;
  const std::vector<NamedValues> values = frame_values(copy);
  steps_->write(frame_of(copy, values));
}

void FrameOutput::finish() {
  for (const auto& writer : others_) writer->finish();
}

std::vector<int> FrameOutput::missing_frames(const Simulation& simulation, int last) const {
  const bool has_bodies = needs_former_frames() && !simulation.body_positions().empty();
  std::vector<int> missing;
  for (int number = 0; number <= last; ++number) {
    const auto there = [&](const char* stem) {
      std::error_code ignored;
      return fs::exists(numbered(out_ / "frames", stem, number, kFrameFileDigits, ".ply"), ignored);
    };
    if (!there("cloth") || (has_bodies && bodies_due(simulation, number) && !there("bodies")))
      missing.push_back(number);
  }
  return missing;
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
