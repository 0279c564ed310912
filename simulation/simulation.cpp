// SPDX-License-Identifier: MIT
#include <selvedge/scene/build.h>
#include <selvedge/simulation/detail/mesh_changes.h>
#include <selvedge/simulation/detail/simulation_parts.h>
#include <selvedge/simulation/internal/mesh_change.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/simulation/step_report.h>

#include <stdexcept>
#include <utility>

namespace selvedge {

Simulation::Simulation(const Scene& scene) : Simulation(scene, Methods{}) {}
Simulation::Simulation(const Scene& scene, const Methods& methods)
    : Simulation(scene, build_scene(scene, methods), methods) {}
Simulation::Simulation(const Scene& scene, BuiltScene built)
    : Simulation(scene, std::move(built), Methods{}) {}
Simulation::Simulation(const Scene& scene, BuiltScene built, const Methods& methods) {
  if (!mesh_change(scene).empty()) changes_ = std::make_unique<MeshChanges>(scene, built, methods);
  parts_ = std::make_shared<Parts>(with_fixed_mesh(scene), std::move(built), methods);
  parts_->start(methods);
}
Simulation::Simulation(const Scene& scene, BuiltScene built, SimulationState state)
    : Simulation(scene, std::move(built), std::move(state), Methods{}) {}
Simulation::Simulation(const Scene& scene, BuiltScene built, SimulationState state,
                       const Methods& methods) {
  if (!mesh_change(scene).empty()) changes_ = std::make_unique<MeshChanges>(scene, built, methods);
  if (changes_ && detail::has_changes(state)) {
    changes_->refinement.repeat(state);
    parts_ = changes_->parts_at(changes_->refinement, std::move(state));
  } else {
    parts_ = std::make_shared<Parts>(with_fixed_mesh(scene), std::move(built), methods);
    parts_->continue_at(std::move(state));
  }
}
Simulation::~Simulation() = default;

void Simulation::step() {
  if (change_mesh()) return;
  if (parts_->wrenches && is_at_frame()) parts_->wrenches->begin_mean();
  parts_->threads.run([&] { parts_->make_step(parts_->control()); });
}

bool Simulation::step_towards(int frame) {
  if (reached(frame)) return false;
  step();
  return true;
}

void Simulation::advance_to_frame(int frame, const std::function<void(double)>& accepted) {
  if (reached(frame)) verify_frame();
  while (step_towards(frame)) {
    if (accepted) accepted(parts_->state.time);
    if (is_at_frame()) verify_frame();
  }
}

bool Simulation::reached(int frame) const {
  return parts_->control().done >= std::int64_t{frame} * parts_->scene.time.steps_per_frame;
}

int Simulation::frame() const {
  return static_cast<int>(parts_->control().done / parts_->scene.time.steps_per_frame);
}

bool Simulation::is_at_frame() const {
  return !(parts_->state.control.h > 0.0) &&
         parts_->control().done % parts_->scene.time.steps_per_frame == 0;
}

void Simulation::verify_frame() { parts_->verify_frame(); }

double Simulation::time() const { return parts_->state.time; }
std::span<const Vec3> Simulation::positions() const { return parts_->state.x; }
std::span<const Vec3> Simulation::velocities() const { return parts_->state.v; }

std::vector<StepContact> Simulation::contacts() const {
  if (!parts_->attempts.accepted) return {};
  return detail::step_contacts(*parts_->methods.response, parts_->outcome);
}

std::map<std::string, double> Simulation::energies() const {
  const SimulationState& state = parts_->state;
  return selvedge::energies(parts_->scene, parts_->built, {state.x, state.v, mass(), state.time},
                            parts_->force_laws);
}

const SimulationState& Simulation::state() const { return parts_->state; }

// A scene has one history of changes, so that the mesh follows from their number.
bool Simulation::is_of_present_mesh(const SimulationState& state) const {
  const SimulationState& now = parts_->state;
  return !changes_ ||
         (state.splits.size() == now.splits.size() && state.merges.size() == now.merges.size());
}

void Simulation::restore(SimulationState state) {
  if (changes_) changes_->passed.clear();
  if (is_of_present_mesh(state)) return parts_->restore(std::move(state));
  const bool measures = measures_wrenches();
  RunResult before = parts_->present_result();
  changes_->repeat(state, build_scene(changes_->scene, changes_->methods));
  parts_ = changes_->parts_at(changes_->refinement, std::move(state));
  parts_->continue_from(std::move(before));
  parts_->measure_wrenches(measures);
}

void Simulation::resume(SimulationState state, RunResult before) {
  restore(std::move(state));
  parts_->continue_from(std::move(before));
}

const StepReport& Simulation::last_step() const { return parts_->attempts; }

void Simulation::measure_wrenches(bool on) { parts_->measure_wrenches(on); }
bool Simulation::measures_wrenches() const { return parts_->wrenches.has_value(); }

const StepWrenches& Simulation::wrenches() const {
  if (!parts_->wrenches)
    throw std::logic_error("wrenches are not measured: call measure_wrenches first");
  return parts_->wrenches->last();
}

StepWrenches Simulation::frame_wrenches() const {
  if (!parts_->wrenches)
    throw std::logic_error("wrenches are not measured: call measure_wrenches first");
  return parts_->wrenches->mean();
}
const VertexNames& Simulation::names() const { return parts_->methods.names; }
void Simulation::set_trace(const StepTrace* trace) { parts_->methods.trace = trace; }
std::vector<std::uint8_t> Simulation::flags() const { return parts_->flags(); }

const BuiltScene& Simulation::built() const { return parts_->built; }
const std::vector<double>& Simulation::mass() const { return parts_->input.particles.mass; }
std::span<const Triangle> Simulation::cloth_triangles() const {
  return parts_->built.cloth.surface.triangles;
}
std::span<const Triangle> Simulation::body_triangles() const {
  return parts_->methods.detection.body_triangles();
}
const std::vector<Vec3>& Simulation::body_positions() const { return parts_->body_x; }
bool Simulation::bodies_move() const {
  return detail::bodies_move(parts_->built, 0.0,
                             parts_->scene.time.frames / parts_->scene.time.fps);
}

std::shared_ptr<const void> Simulation::owner() const { return parts_; }

RestReport Simulation::rest() { return parts_->rest(); }
bool Simulation::is_at_rest() { return parts_->is_slow() && parts_->rest().at_rest; }

RunResult Simulation::result() const { return parts_->present_result(); }

FinalState Simulation::end() && {
  FinalState last{.built = std::move(parts_->built),
                  .state = std::move(parts_->state),
                  .mass = std::move(parts_->input.particles.mass)};
  parts_.reset();
  return last;
}

}  // namespace selvedge
