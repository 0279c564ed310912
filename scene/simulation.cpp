// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/detail/simulation_parts.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace selvedge {
namespace {

// A step that covers this share of the time that is left goes to its end.
constexpr double kAllThatIsLeft = 1.0 - 1e-9;

// Halvings that a gain of energy leaves for steps that are not clean. Fewer for it save nothing:
// with sixteenths of a step alone what hangs on impulses runs off all the same, and takes longer.
constexpr int kLeftForClean = 2;

// Share of the stable step that is used.
constexpr double kExplicitSafety = 0.9;

double max_norm(std::span<const Vec3> v) {
  double largest = 0.0;
  for (const Vec3& u : v) largest = std::max(largest, u.squaredNorm());
  return std::sqrt(largest);
}

}  // namespace

// The longest step that the integrator bears from the present state, s, at most h; 0: none.
double Simulation::Parts::longest_step(double h) {
  if (method.any_step) return h;
  particles.x = state.x;
  particles.v = state.v;
  hold_particles(state.time, state.time + h, h);
  return kExplicitSafety * integrator->stable_step(particles, state.time, h / kExplicitSafety);
}

// What is refused before the first step is the input's fault.
void Simulation::Parts::refuse_unstable_start() {
  if (n() == 0) return;
  const double h = nominal_step(), stable = longest_step(h);
  const std::string& name = scene.solver.integrator;
  if (!(stable > 0.0))
    throw std::invalid_argument(
        "solver.integrator: \"" + name +
        "\" grows in every step of this cloth, however short; give its springs damping "
        "(materials: spring_damping), or take verlet or implicit_euler");
  if (scene.solver.refuse_unstable_step && stable < h * kAllThatIsLeft)
    throw std::invalid_argument(
        fmt::format("solver.integrator: \"{}\" bears steps of {:.3g} s here, the scene has {:.3g} "
                    "s; set time.steps_per_frame to {} or solver.unstable_step to \"substep\"",
                    name, stable, h,
                    static_cast<long long>(std::ceil(scene.time.steps_per_frame * h / stable))));
}

// Steps keep within what integrator and contacts bear.
double Simulation::Parts::stable_step(double h, double target) {
  double stable = longest_step(h);
  if (!(stable >= h) && scene.solver.refuse_unstable_step)
    throw SimulationFailed(
        FailureKind::unstable_step,
        fmt::format("unstable step at {} s: {} bears {:.3g} s, the step has {:.3g} "
                    "s; solver.unstable_step is \"refuse\"",
                    state.time, scene.solver.integrator, stable, h));
  if (!method.is_implicit)
    stable =
        std::min(stable, kExplicitSafety * response->stable_step(detail::contact_inv_mass(mass)));
  if (stable >= h) return h;
  const double left = target - state.time;
  return std::min(h, left / std::ceil(left / stable));
}

// One accepted step towards the end of the nominal step; halved until it is clean.
void Simulation::Parts::make_step(StepControl control) {
  // Targets are computed from whole numbers, so that steps do not drift and a resumed run meets
  // them.
  const double target = static_cast<double>(control.done + 1) * nominal_step();
  tried.clear();
  balance.begin();
  for (;; control.h *= 0.5, ++result.halvings) {
    control.h = stable_step(control.h, target);
    const bool to_target = control.h >= (target - state.time) * kAllThatIsLeft;
    const double t1 = to_target ? target : state.time + control.h;
    const double h = t1 - state.time;
    tried.push_back(h);
    if (!(h > 0.0))
      throw SimulationFailed(FailureKind::stalled, "a step of " + std::to_string(control.h) +
                                                       " s is too short to advance the time of " +
                                                       std::to_string(state.time) + " s");
    if (!try_step(h, t1)) {
      note_failure(h);
      if (++control.halvings > scene.time.max_halvings) give_up();
      continue;
    }
    if (gains_energy(h) && control.halvings + kLeftForClean < scene.time.max_halvings &&
        balance.wants_shorter()) {
      ++control.halvings;
      continue;
    }
    accept(h, t1);
    if (control.halvings > 0) {
      --control.halvings;
      control.h = std::min(2.0 * control.h, nominal_step());
    }
    state.control = state.time < target ? control : StepControl{};
    return;
  }
}

// What the next try overwrites.
void Simulation::Parts::note_failure(double h) {
  failed.h = h;
  failed.trouble = trouble;
  failed.pairs = hits;
  failed.x_t0 = x_t0;
  failed.x_t1 = hits.empty() ? x_t1 : unparted;
  if (!hits.empty()) failed.not_finite = -1;
}

void Simulation::Parts::give_up() {
  result.clean = false;
  std::string cause = "no clean step at " + std::to_string(state.time) + " s after " +
                      std::to_string(scene.time.max_halvings) + " halvings: " + failed.trouble;
  if (!failed.pairs.empty())
    cause += "; of " + std::to_string(failed.pairs.size()) +
             " pairs that still collide the first is " + names.pair(failed.pairs[0]);
  throw SimulationFailed(failed.not_finite >= 0 ? FailureKind::not_finite : FailureKind::not_clean,
                         cause);
}

Simulation::Simulation(const Scene& scene, BuiltScene built, const Methods& methods)
    : parts_(std::make_unique<Parts>(scene, std::move(built), methods)) {}
Simulation::~Simulation() = default;

StepControl Simulation::Parts::control() const {
  if (state.control.h > 0.0) return state.control;
  return {std::llround(state.time / nominal_step()), nominal_step(), 0};
}

bool Simulation::reached(int frame) const {
  return parts_->control().done >= std::int64_t{frame} * parts_->scene.time.steps_per_frame;
}

bool Simulation::step_towards(int frame) {
  if (reached(frame)) return false;
  parts_->make_step(parts_->control());
  return true;
}

void Simulation::advance_to_frame(int frame, const std::function<void(double)>& accepted) {
  while (step_towards(frame))
    if (accepted) accepted(parts_->state.time);
  verify_frame();
}
void Simulation::verify_frame() { parts_->verify_frame(); }
const SimulationState& Simulation::state() const { return parts_->state; }
void Simulation::restore(SimulationState state) {
  if (state.x.size() != parts_->n() || state.v.size() != parts_->n())
    throw std::invalid_argument("the saved state has " + std::to_string(state.x.size()) +
                                " particles, but the scene has " + std::to_string(parts_->n()) +
                                "; resume with the scene that was run");
  parts_->integrator->restore_memory(state.memory);
  parts_->state = std::move(state);
  if (parts_->water) parts_->water->restore(parts_->state, parts_->mass);
  parts_->particles.mass = parts_->mass;
  parts_->place_bodies(parts_->state.time, parts_->x_t0);
  parts_->note_bodies(parts_->x_t0);
  if (parts_->untangler) parts_->resume_untangling();
}

const std::vector<double>& Simulation::tried() const { return parts_->tried; }
const FailedTry& Simulation::failed_try() const { return parts_->failed; }
const VertexNames& Simulation::names() const { return parts_->names; }
void Simulation::set_trace(const StepTrace* trace) { parts_->trace = trace; }
std::vector<std::uint8_t> Simulation::flags() const { return parts_->flags(); }
const BuiltScene& Simulation::built() const { return parts_->built; }
const std::vector<double>& Simulation::mass() const { return parts_->mass; }
std::span<const Triangle> Simulation::cloth_triangles() const {
  return parts_->built.cloth.surface.triangles;
}
std::span<const Triangle> Simulation::body_triangles() const { return parts_->body_triangles; }
const std::vector<Vec3>& Simulation::body_positions() const { return parts_->body_x; }
bool Simulation::bodies_move() const {
  const double end = parts_->scene.time.frames / parts_->scene.time.fps;
  return parts_->bodies_move(0.0, end);
}
RunResult Simulation::result() const {
  RunResult result = parts_->result;
  for (const auto& [name, value] : parts_->fail_safe->counters()) result.counters[name] = value;
  result.ledger = parts_->ledger.figures();
  result.ledger["balance"] = parts_->balance.figures();
  if (parts_->strain_stage.acts()) result.ledger["strain_limiter"] = parts_->strain_stage.figures();
  result.plan = parts_->plan_figures();
  if (parts_->water) result.counters["dripped_kg"] += parts_->water->dripped();
  result.phase_s = parts_->clock.seconds();
  if (parts_->untangler) {
    result.tangle = parts_->untangler->report();
    result.clean = result.clean && result.tangle.elsewhere == 0;
  }
  result.clean_elsewhere = result.clean;
  result.clean = result.clean && !parts_->untangling();
  result.final_max_speed = max_norm(parts_->state.v);
  result.state_hash = selvedge::state_hash(parts_->state);
  return result;
}

}  // namespace selvedge
