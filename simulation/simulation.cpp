// SPDX-License-Identifier: MIT
#include <selvedge/simulation/detail/simulation_parts.h>
#include <selvedge/simulation/refinement.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>

#include <stdexcept>
#include <utility>

namespace selvedge {
namespace {

const Scene& with_one_mesh(const Scene& scene) {
  if (const std::string cause = mesh_change(scene); !cause.empty())
    throw std::invalid_argument(
        cause +
        " changes the mesh between frames, which Simulation does not: make a RefiningSimulation or "
        "call run_scene; with_fixed_mesh(scene) leaves the changes out");
  return scene;
}

}  // namespace

Simulation::Simulation(const Scene& scene, const Methods& methods)
    : Simulation(with_one_mesh(scene), build_scene(scene, methods), methods) {}
Simulation::Simulation(const Scene& scene, BuiltScene built, const Methods& methods)
    : parts_(std::make_unique<Parts>(with_one_mesh(scene), std::move(built), methods)) {
  parts_->start(methods);
}
Simulation::Simulation(const Scene& scene, BuiltScene built, SimulationState state,
                       const Methods& methods)
    : parts_(std::make_unique<Parts>(with_one_mesh(scene), std::move(built), methods)) {
  if (state.memory.empty()) state.memory = parts_->state.memory;
  parts_->start_untangling();
  parts_->restore(std::move(state));
  parts_->note_strain();
}
Simulation::~Simulation() = default;

void Simulation::step() {
  parts_->threads.run([&] { parts_->make_step(parts_->control()); });
}

bool Simulation::step_towards(int frame) {
  if (reached(frame)) return false;
  step();
  return true;
}

void Simulation::advance_to_frame(int frame, const std::function<void(double)>& accepted) {
  while (step_towards(frame))
    if (accepted) accepted(parts_->state.time);
  verify_frame();
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
  return step_contacts(*parts_->methods.response, parts_->attempt);
}

std::map<std::string, double> Simulation::energies() const {
  const SimulationState& state = parts_->state;
  return selvedge::energies(parts_->scene, parts_->built, {state.x, state.v, mass(), state.time},
                            parts_->force_laws);
}

const SimulationState& Simulation::state() const { return parts_->state; }
void Simulation::restore(SimulationState state) { parts_->restore(std::move(state)); }
void Simulation::continue_sums(RunResult& before) { parts_->continue_sums(before); }

const std::vector<double>& Simulation::attempt_lengths() const { return parts_->attempts.lengths; }
const RejectedAttempt& Simulation::rejected_attempt() const { return parts_->attempts.failed; }
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

RunResult Simulation::result() const { return parts_->present_result(); }

FinalState Simulation::end() && {
  FinalState last{.built = std::move(parts_->built),
                  .state = std::move(parts_->state),
                  .mass = std::move(parts_->input.particles.mass)};
  parts_.reset();
  return last;
}

}  // namespace selvedge
