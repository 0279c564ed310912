// SPDX-License-Identifier: MIT
//
// What a program sets between steps: forces, held particles, and the vertices of bodies.
#include <fmt/format.h>
#include <selvedge/bodies/driven_body.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/detail/mesh_changes.h>
#include <selvedge/simulation/detail/simulation_parts.h>
#include <selvedge/simulation/internal/mesh_change.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace selvedge {
namespace {

void refuse_not_finite(std::span<const Vec3> values, const char* what) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!values[i].allFinite())
      throw std::invalid_argument(fmt::format("{}[{}] is not finite", what, i));
}

void refuse_outside(std::span<const std::int32_t> vertices, std::size_t n) {
  for (std::size_t k = 0; k < vertices.size(); ++k)
    if (vertices[k] < 0 || static_cast<std::size_t>(vertices[k]) >= n)
      throw std::invalid_argument(
          fmt::format("vertices[{}] is {}; the cloth has vertices 0 to {}", k, vertices[k], n - 1));
}

}  // namespace

DrivenBody& drive_body(BuiltScene& built, std::size_t body) {
  if (body >= built.bodies.size())
    throw std::invalid_argument(
        fmt::format("there is no body {}; the scene has {}, from 0 on", body, built.bodies.size()));
  auto driven = std::make_unique<DrivenBody>(*built.bodies[body]);
  DrivenBody& reference = *driven;
  built.bodies[body] = std::move(driven);
  return reference;
}

double Simulation::nominal_end() const {
  const StepControl control = parts_->control();
  return static_cast<double>(control.done + control.span) * parts_->nominal_step();
}

// They are numbered by vertices and bodies, which a change of the mesh replaces.
void Simulation::refuse_changing_mesh() const {
  if (!changes_) return;
  throw std::invalid_argument(
      mesh_change(changes_->scene) +
      " changes the mesh; forces, held vertices and driven bodies need one that stays");
}

void Simulation::set_forces(std::span<const Vec3> forces) {
  refuse_changing_mesh();
  if (!forces.empty() && forces.size() != parts_->n())
    throw std::invalid_argument(fmt::format("forces: {} are given for {} vertices of the cloth",
                                            forces.size(), parts_->n()));
  refuse_not_finite(forces, "forces");
  parts_->methods.program.force.assign(forces.begin(), forces.end());
  parts_->balance.forget();
  parts_->wake();
}

void Simulation::hold(std::span<const std::int32_t> vertices, std::span<const Vec3> x) {
  refuse_changing_mesh();
  if (vertices.size() != x.size())
    throw std::invalid_argument(
        fmt::format("{} positions are given for {} vertices to hold", x.size(), vertices.size()));
  refuse_outside(vertices, parts_->n());
  refuse_not_finite(x, "x");
  std::vector<char> follows(parts_->n(), 0);
  for (const std::int32_t i : parts_->methods.followers.nodes()) follows[i] = 1;
  for (const std::int32_t i : vertices)
    if (follows[i] != 0)
      throw std::invalid_argument(fmt::format(
          "{} follows other vertices and cannot be held; hold its neighbours", names().vertex(i)));
  for (std::size_t k = 0; k < vertices.size(); ++k)
    parts_->methods.program.hold(
        {vertices[k], parts_->state.x[vertices[k]], x[k], time(), nominal_end()});
  parts_->wake();
}

void Simulation::release(std::span<const std::int32_t> vertices) {
  refuse_outside(vertices, parts_->n());
  for (const std::int32_t i : vertices) parts_->methods.program.release(i);
  parts_->wake();
}

void Simulation::release_all() {
  parts_->methods.program.held.clear();
  parts_->wake();
}

void Simulation::move_body(DrivenBody& body, std::span<const Vec3> x) {
  refuse_changing_mesh();
  const auto& bodies = parts_->built.bodies;
  if (std::none_of(bodies.begin(), bodies.end(), [&](const auto& b) { return b.get() == &body; }))
    throw std::invalid_argument("the body to move is not a body of this simulation");
  body.move_to(x, time(), nominal_end());
  parts_->wake();
}

}  // namespace selvedge
