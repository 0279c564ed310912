// SPDX-License-Identifier: MIT
//
// How a simulation starts: its methods, its first state, and the starts that it refuses.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <selvedge/core/base/internal/floating_point.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/detail/handles.h>
#include <selvedge/simulation/detail/simulation_parts.h>
#include <selvedge/simulation/detail/useful_threads.h>
#include <selvedge/simulation/internal/carried.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace selvedge {
namespace {

/// The forces of the scene on `cloth`, and those that the program sets.
ForceList all_forces(const Scene& scene, const BuiltScene& built, const ClothMesh& cloth,
                     const Methods& methods, const detail::ProgramInput& program) {
  ForceList forces = make_forces(scene, built, cloth, methods);
  forces.push_back(detail::make_program_force(program));
  return forces;
}

// What a body on a hinge turns by is small beside the forces that would have stopped it on the
// straight way of its old velocity: these set the scale of the tolerance.
double hinge_share(const BuiltScene& built) {
  const bool has_hinge =
      std::ranges::any_of(built.solids, [](const BuiltSolid& solid) { return solid.lever > 0.0; });
  return has_hinge ? 1e-5 : 1.0;
}

std::unique_ptr<Integrator> make_integrator(const Scene& scene, const BuiltScene& built,
                                            const Methods& methods,
                                            const detail::ProgramInput& program) {
  const auto make = [&](std::vector<std::unique_ptr<Force>> forces, std::size_t particles) {
    return make_method(methods.integrators, scene.solver.integrator, "solver.integrator",
                       scene.solver.integrator_options, std::move(forces), particles,
                       {.tolerance = scene.solver.tolerance * hinge_share(built),
                        .exact_momentum = !built.solids.empty()});
  };
  const Followers followers(built.cloth), layers = Followers::of_layers(built.cloth);
  if (!followers.empty())
    return make_following(followers, all_forces(scene, built, built.cloth, methods, program), make);
  if (!layers.empty()) {
    const LayerParts parts = split_layers(built.cloth);
    auto local = make_internal_forces(parts.local, methods.force_laws, scene.force_laws);
    return make_layered(layers, all_forces(scene, built, parts.carrying, methods, program),
                        std::move(local), make);
  }
  return make(all_forces(scene, built, built.cloth, methods, program),
              built.cloth.surface.vertices.size());
}

void note_critical_step(const Scene& scene, const BuiltScene& built, const Methods& methods,
                        double h, RunResult& result) {
  const std::size_t n = built.cloth.surface.vertices.size();
  ForceSum forces(make_forces(scene, built, methods), n);
  Particles particles{built.cloth.surface.vertices, built.velocity, built.cloth.mass, {}};
  for (const double m : particles.mass) particles.inv_mass.push_back(1.0 / m);
  const CriticalStep step = critical_step(forces, particles, h);
  result.counters["max_critical_step_s"] = step.longest_step;
  result.counters["max_critical_stiffness_factor"] = step.stiffening;
  result.counters["max_provot_stiffness_N_per_m"] = step.provot_stiffness;
}

/// The detector of the scene that may miss collisions; "" if none may.
std::string missing_detector(const ContactSpec& contact, const Methods& methods) {
  if (methods.broad_phases.at(contact.broad_phase).traits().guarantee == Guarantee::approximate)
    return contact.broad_phase;
  const auto narrow = methods.narrow_phases.at(contact.narrow_phase)(contact.narrow_phase_options);
  return narrow->traits().misses_nothing ? "" : contact.narrow_phase;
}

constexpr std::size_t kMostNamed = 3;  // pairs of surfaces

/// Which pairs of surfaces the scene excludes.
std::string excluded_pairs(const ContactPairs& pairs, const VertexNames& names) {
  std::vector<std::string> named;
  for (const auto& [a, b] : pairs.excluded())
    if (named.size() < kMostNamed)
      named.push_back(a == b ? names.owner_name(a) + " and itself"
                             : names.owner_name(a) + " and " + names.owner_name(b));
  if (const std::size_t more = pairs.excluded().size() - named.size(); more > 0)
    named.push_back(fmt::format("{} more", more));
  return fmt::format(
      "{} of {} pairs of surfaces were not checked between frames (collide: false): {}",
      pairs.excluded().size(), pairs.count(), fmt::join(named, "; "));
}

/// RunResult::unchecked.
std::string unchecked_between_frames(const Scene& scene, const Methods& methods,
                                     const VertexNames& names) {
  std::vector<std::string> parts;
  if (!scene.contact.self)
    parts.emplace_back("cloth was not checked against itself between frames (contact.self: false)");
  if (const ContactPairs pairs(scene); !pairs.excluded().empty())
    parts.push_back(excluded_pairs(pairs, names));
  if (const std::string misses = missing_detector(scene.contact, methods); !misses.empty())
    parts.push_back(misses + " may miss collisions between frames");
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace

namespace detail {

StepMethods::StepMethods(const Scene& s, const BuiltScene& built, const Methods& methods,
                         detail::PhaseClock& phases)
    : scene(s),
      detection(scene, built, methods, phases),
      strain(scene, built, methods.strain_limiters),
      followers(built.cloth),
      layers(Followers::of_layers(built.cloth)),
      integrator(make_integrator(scene, built, methods, program)),
      traits(integrator->traits()),
      response(make_method(methods.responses, scene.contact.response, "contact.response",
                           scene.contact.response_options)),
      fail_safe(make_method(methods.fail_safes, scene.contact.fail_safe, "contact.fail_safe",
                            scene.contact.fail_safe_options)),
      sewing(scene, built),
      stops(scene, built),
      names(scene, built),
      pinches(detection),
      validator(scene.contact.broad_phase),
      clock(phases) {}

}  // namespace detail

Simulation::Parts::Parts(const Scene& s, BuiltScene b, const Methods& m)
    : scene(s),
      built(detail::with_policy(scene, std::move(b), m.strain_limiters)),
      methods(scene, built, m, clock),
      force_laws(m.force_laws),
      turning(scene, built),
      joined(scene, built, methods.traits),
      sleep(scene, built),
      threads(detail::useful_threads(scene, built)),
      balance(scene, built, methods.response->traits()) {
  detail::refuse_bad_handles(scene, built);
  if (!built.solids.empty() && !(methods.traits.is_implicit && methods.traits.any_step))
    throw std::invalid_argument(fmt::format(
        "solver.integrator: \"{}\" cannot move bodies with \"mass\"; take implicit_blend or "
        "implicit_euler",
        scene.solver.integrator));
  if (!methods.traits.is_implicit)
    detail::refuse_unfit_response(scene, m.responses, *methods.response, built.cloth.mass);
  result.unchecked = unchecked_between_frames(scene, m, methods.names);
  state.x = built.cloth.surface.vertices;
  state.v = built.velocity;
  note_memory();
  const std::size_t joint = n() + methods.detection.body_vertices();
  input.particles = {state.x, state.v, built.cloth.mass, std::vector<double>(n(), 0.0)};
  input.inv_mass.assign(joint, 0.0);
  input.x_t0.resize(joint);
  input.body_step.resize(methods.detection.body_vertices());
  if (scene.water) water.emplace(scene, built);
  if (!methods.followers.empty()) input.followers = &methods.followers;
  input.program = &methods.program;
  detail::place_bodies(built, state.time, input.x_t0);
  note_bodies(input.x_t0);
}

void Simulation::Parts::start(const Methods& m) {
  require_ieee_arithmetic();
  refuse_bad_start();
  if (detail::limiter_kind(scene, m.strain_limiters) == LimiterKind::critical_step)
    note_critical_step(scene, built, m, nominal_step(), result);
  note_strain();
  count_flags(flags(), result.flags);
}

void Simulation::Parts::refuse_bad_start() {
  const detail::Crossings found = crossings_now();
  const ContactSpec& contact = scene.contact;
  if (!contact.untangle_start)
    detail::refuse_crossings(found, contact.self);
  else if (contact.self)
    detail::refuse_folded(found, built.cloth.surface.triangles);
  refuse_enclosed_start(start_untangling());
  refuse_unstable_start();
}

// Cloth that starts outside of every closed body stays outside, because it would have to pass
// through the surface.
void Simulation::Parts::refuse_enclosed_start(std::span<const EdgeCrossing> crossings) {
  const auto scope = clock.measure("verify");
  if (const auto found =
          detail::find_enclosed(methods.detection.joint_surface(), input.x_t0, crossings))
    throw std::invalid_argument(enclosed_sentence(*found, "at the start") +
                                "; move the cloth out of it or, if the body is a room, give its "
                                "walls a thickness or leave a face of it out");
}

// The crossings of the start; none if the scene neither untangles nor carries jams on.
std::vector<EdgeCrossing> Simulation::Parts::start_untangling() {
  if (!scene.contact.untangle_start && !scene.contact.carry_tangled) return {};
  look_at_state();
  std::vector<EdgeCrossing> crossings = methods.detection.find_edge_crossings();
  methods.untangler = std::make_unique<detail::Untangler>(methods.detection.joint_surface(),
                                                          detail::UntangleConfig{});
  methods.untangler->start(input.x_t0, crossings);
  methods.detection.set_excluded(&methods.untangler->excluded());
  state.tangles = methods.untangler->tangles();
  return crossings;
}

// A state without memory starts with that of the integrator and the forces at the start.
void Simulation::Parts::continue_at(SimulationState saved) {
  if (saved.memory.empty()) saved.memory = state.memory;
  start_untangling();
  restore(std::move(saved));
  note_strain();
}

void Simulation::Parts::restore(SimulationState saved) {
  if (saved.x.size() != n() || saved.v.size() != n())
    throw std::invalid_argument("the saved state has " + std::to_string(saved.x.size()) +
                                " particles, but the scene has " + std::to_string(n()) +
                                "; resume with the scene that was run");
  detail::refuse_bad_pinches(saved.pinches, n(), methods.detection.body_triangles().size());
  methods.integrator->restore_memory(saved.memory);
  methods.response->restore_memory(saved.contact_memory, input.x_t0.size());
  state = std::move(saved);
  if (water) water->restore(state, input.particles.mass);
  attempts.accepted = attempts.given_up = false;
  outcome = {};
  uncrossed = false;
  balance.forget();
  methods.program.force.clear();
  methods.program.held.clear();
  detail::place_bodies(built, state.time, input.x_t0);
  note_bodies(input.x_t0);
  forget_bodies();
  if (!methods.untangler) return;
  methods.untangler->set_pinches(state.pinches);
  look_at_state();
  methods.untangler->resume(state.tangles, input.x_t0, methods.detection.find_edge_crossings());
}

// Bodies that rest before and after may rest at another place.
void Simulation::Parts::forget_bodies() {
  methods.detection.set_motion(input.x_t0, input.x_t0, true);
}

Simulation::Carried Simulation::Parts::give() {
  return {
      .state = std::move(state),
      .program = std::exchange(methods.program, {}),
      .body_x = std::move(body_x),
      .attempts = std::move(attempts),
      .ledger = ledger,
      .balance = balance,
      .strain = methods.strain.acts() ? methods.strain.figures() : std::map<std::string, double>(),
      .dripped = water ? water->dripped() : 0.0,
      .uncrossed = uncrossed,
      .result = std::move(result),
      .before = std::move(before)};
}

// Continues with another simulation of the same scene.
void Simulation::Parts::take(Carried carried) {
  state = std::move(carried.state);
  methods.program = std::move(carried.program);
  body_x = std::move(carried.body_x);
  attempts = std::move(carried.attempts);
  ledger = carried.ledger;
  balance = carried.balance.value();
  uncrossed = carried.uncrossed;
  result = std::move(carried.result);
  before = std::move(carried.before);
  methods.strain.continue_from(carried.strain);
  methods.integrator->restore_memory(state.memory);
  methods.response->restore_memory(state.contact_memory, input.x_t0.size());
  if (water) {
    water->restore(state, input.particles.mass);
    water->continue_from(carried.dripped);
  }
  attempts.accepted = false;  // its contacts are gone
  outcome = {};
  methods.validator.forget();
  std::copy(state.x.begin(), state.x.end(), input.x_t0.begin());
  std::copy(body_x.begin(), body_x.end(), input.x_t0.begin() + static_cast<std::ptrdiff_t>(n()));
  forget_bodies();
}

CarriedSimulation::CarriedSimulation() : content_(std::make_unique<Simulation::Carried>()) {}
CarriedSimulation::~CarriedSimulation() = default;
CarriedSimulation::CarriedSimulation(const CarriedSimulation& other)
    : content_(std::make_unique<Simulation::Carried>(*other.content_)) {}
CarriedSimulation::CarriedSimulation(CarriedSimulation&& other) noexcept = default;
CarriedSimulation& CarriedSimulation::operator=(CarriedSimulation other) noexcept {
  content_ = std::move(other.content_);
  return *this;
}
CarriedSimulation CarriedSimulation::out_of(Simulation& simulation) {
  CarriedSimulation carried;
  *carried.content_ = simulation.parts_->give();
  return carried;
}
void CarriedSimulation::put_into(Simulation& simulation) && {
  simulation.parts_->take(std::move(*content_));
}
const SimulationState& CarriedSimulation::state() const { return content_->state; }

}  // namespace selvedge
