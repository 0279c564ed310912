// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/run/detail/frame_output.h>
#include <selvedge/run/detail/named_wrenches.h>
#include <selvedge/run/internal/flat_texture.h>
#include <selvedge/run/internal/part_colours.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/step_report.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace selvedge {

std::vector<std::array<TexturePoint, 3>> flat_texture(const BuiltScene& built) {
  constexpr TexturePoint none = {std::numeric_limits<double>::quiet_NaN(), 0.0};
  const std::vector<Triangle>& cloth = built.cloth.surface.triangles;
  const TriangleMesh& rest = built.rest;
  std::vector<std::array<TexturePoint, 3>> texture(cloth.size(), {none, none, none});
  const std::size_t pieces = built.piece_begin.empty() ? 0 : built.piece_begin.size() - 1;
  for (std::size_t piece = 0; piece < pieces; ++piece) {
    const auto is_own = [&](std::size_t t) {
      return cloth[t][0] >= built.piece_begin[piece] && cloth[t][0] < built.piece_begin[piece + 1];
    };
    Eigen::AlignedBox3d box;
    for (std::size_t t = 0; t < cloth.size(); ++t)
      if (is_own(t))
        for (const std::int32_t v : rest.triangles[t])
          box.extend(rest.vertices[static_cast<std::size_t>(v)]);
    if (box.isEmpty() || box.sizes().z() > 1e-9 * box.sizes().maxCoeff()) continue;
    const double size = box.sizes().maxCoeff();
    for (std::size_t t = 0; t < cloth.size(); ++t)
      for (std::size_t k = 0; is_own(t) && k < 3; ++k) {
        const Vec3 at = rest.vertices[static_cast<std::size_t>(rest.triangles[t][k])] - box.min();
        texture[t][k] = {at.x() / size, at.y() / size};
      }
  }
  return texture;
}

namespace detail {

namespace fs = std::filesystem;

namespace {

MethodOptions options_of(const OutputSpec& output, const std::string& name) {
  const auto found = output.format_options.find(name);
  return found == output.format_options.end() ? MethodOptions{} : found->second;
}

void add_parts(const FrameParts& parts, Frame& frame) {
  frame.pieces = parts.pieces;
  frame.body_parts = parts.bodies;
  frame.texture = parts.texture;
}

Frame frame_of(const StateCopy& copy, const std::vector<NamedValues>& values) {
  Frame frame = {.number = copy.number,
                 .time = copy.time,
                 .x = copy.state.x,
                 .v = copy.state.v,
                 .triangles = copy.triangles,
                 .values = values,
                 .bodies = copy.bodies,
                 .body_triangles = copy.body_triangles,
                 .wrenches = copy.wrenches};
  if (copy.parts) add_parts(*copy.parts, frame);
  return frame;
}

template <class Spec>
std::vector<std::string> names_of(const std::vector<Spec>& specs, const char* kind) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < specs.size(); ++i)
    names.push_back(specs[i].name.empty() ? fmt::format("{}_{}", kind, i) : specs[i].name);
  return names;
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
      piece_names_(names_of(scene.cloths, "cloth")),
      body_names_(names_of(scene.bodies, "body")),
      fps_(scene.time.fps),
      pressure_(wants_pressure(scene.output)),
      scene_(scene),
      ply_(make_ply_writer(out_ / "frames", kFrameFileDigits)),
      steps_(make_ply_writer(out_ / "steps", kStepFileDigits)) {
  if (wants_wrenches(scene)) step_wrenches_ = make_wrench_table(out_ / "steps" / "wrenches.csv");
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

std::shared_ptr<const FrameParts> FrameOutput::parts_of(const Simulation& simulation) const {
  if (others_.empty()) return nullptr;
  if (parts_ && parts_owner_ == simulation.owner()) return parts_;
  const BuiltScene& built = simulation.built();
  auto parts = std::make_shared<FrameParts>();
  for (std::size_t p = 0; p < piece_names_.size(); ++p) {
    const auto first = static_cast<std::size_t>(built.piece_begin[p]);
    parts->pieces.push_back({piece_names_[p], first,
                             static_cast<std::size_t>(built.piece_begin[p + 1]) - first,
                             piece_dye(p).front});
  }
  std::size_t first = 0;
  for (std::size_t b = 0; b < body_names_.size(); ++b) {
    const std::size_t count = built.bodies[b]->vertex_count();
    parts->bodies.push_back({body_names_[b], first, count, body_colour()});
    first += count;
  }
  parts->texture = flat_texture(built);
  parts_ = std::move(parts);
  parts_owner_ = simulation.owner();
  return parts_;
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
      .wrenches = simulation.measures_wrenches() && number > 0
                      ? named_wrenches(scene_, simulation, simulation.frame_wrenches())
                      : std::vector<NamedWrench>(),
      .owner = simulation.owner(),
      .parts = parts_of(simulation)};
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

void FrameOutput::write_passed(const Simulation& simulation) {
  for (const PassedState& passed : simulation.passed()) {
    StateCopy copy = copy_frame(simulation, static_cast<int>(passed.step));
    copy.time = copy.state.time;
    copy.state.x = passed.x;
    copy.state.v = passed.v;
    copy.flags = passed.flags;
    copy.pressure.assign(pressure_ ? passed.x.size() : 0, 0.0);  // as after every change of a mesh
    copy.triangles = passed.triangles;
    const std::vector<NamedValues> values = frame_values(copy);
    steps_->write(frame_of(copy, values));
  }
}

void FrameOutput::write_step(const Simulation& simulation, int number) {
  write_passed(simulation);
  StateCopy copy = copy_frame(simulation, number);
  copy.time = copy.state.time;
  if (step_wrenches_ && number > 0)
    copy.wrenches = named_wrenches(scene_, simulation, simulation.wrenches());
  const std::vector<NamedValues> values = frame_values(copy);
  steps_->write(frame_of(copy, values));
  if (step_wrenches_) step_wrenches_->write(frame_of(copy, values));
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
    Frame frame = {.number = number,
                   .time = number / fps_,
                   .x = cloth.vertices,
                   .v = v,
                   .triangles = cloth.triangles,
                   .values = values,
                   .bodies = bodies.vertices,
                   .body_triangles = bodies.triangles};
    if (cloth.vertices.size() == simulation.positions().size())  // else a frame of another mesh
      add_parts(*parts_of(simulation), frame);
    for (const auto& writer : others_) writer->write(frame);
  }
  for (const auto& writer : others_) writer->update_series();
}

}  // namespace detail

}  // namespace selvedge
