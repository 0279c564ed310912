// SPDX-License-Identifier: MIT
//
// From one accepted state to the next: the length of a step, its attempts, its acceptance.
#include <fmt/format.h>
#include <selvedge/core/base/internal/floating_point.h>
#include <selvedge/simulation/detail/enclosed.h>
#include <selvedge/simulation/detail/inquiry.h>
#include <selvedge/simulation/detail/simulation_parts.h>
#include <selvedge/simulation/detail/solids.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace selvedge {
namespace {

// A step that covers this share of the remaining time goes to its end.
constexpr double kAllThatIsLeft = 1.0 - 1e-9;

// Halvings that a gain of energy leaves for steps with collisions. Fewer of them gain nothing: with
// sixteenths of a step, cloth that hangs on impulses still diverges, and takes longer.
constexpr int kLeftForClean = 2;

// Share of the stable step that is used.
constexpr double kExplicitSafety = 0.9;

// Whether another attempt of the same length would be by a method that gains less energy.
bool has_other_method(const IntegratorTraits& traits, const detail::SolvedVelocities& v) {
  return traits.follows_energy && v.free != v.mean;
}

// The velocity of the bodies and held particles in a step whose balance is known; without any, that
// of the centre of mass.
Vec3 common_velocity(const detail::StepInput& in, std::span<const Vec3> x_t1) {
  for (std::size_t i = 0; i < in.inv_mass.size(); ++i)
    if (!(in.inv_mass[i] > 0.0)) return (x_t1[i] - in.x_t0[i]) / in.h;
  Vec3 momentum = Vec3::Zero();
  double mass = 0.0;
  for (std::size_t i = 0; i < in.n(); ++i) {
    momentum += in.particles.mass[i] * in.particles.v[i];
    mass += in.particles.mass[i];
  }
  return momentum / mass;
}

// J, what the bodies and held particles did to the cloth in the attempt, by the impulses that the
// method itself exchanged with them: with those, implicit Euler gains nothing. nullopt: the method
// does not keep them, or something moved particles after its solve.
std::optional<double> anchor_work(detail::StepMethods& m, const detail::StepInput& in,
                                  const detail::StepOutcome& outcome,
                                  std::span<const ContactImpulse> contacts) {
  const std::span<const Vec3> x_t1 = outcome.x_t1();
  for (std::size_t i = 0; i < in.n(); ++i)
    if (in.inv_mass[i] > 0.0 && x_t1[i] != in.x_t0[i] + in.h * outcome.v.mean[i])
      return std::nullopt;
  std::vector<Vec3> impulses;
  if (!m.integrator->net_impulses(outcome.v.mean, impulses)) return std::nullopt;
  const auto displacement = [&](std::size_t i) {
    return in.inv_mass[i] > 0.0 ? Vec3(Vec3::Zero()) : Vec3(x_t1[i] - in.x_t0[i]);
  };
  double given = 0.0;  // J s
  for (std::size_t i = 0; i < in.n(); ++i) given -= impulses[i].dot(displacement(i));
  for (const ContactImpulse& c : contacts)
    for (int k = 0; k < 4; ++k)
      given -= c.weight[k] * c.impulse.dot(displacement(static_cast<std::size_t>(c.vertex[k])));
  return given / in.h;
}

// Takes as much of the difference between the end velocities and the mean ones out of an attempt as
// it gains energy. Returns the energy that this takes, J.
double temper(const detail::StepInput& in, double gain, std::span<const Vec3> v_end, bool notes,
              detail::StepOutcome& outcome) {
  const Vec3 frame = common_velocity(in, outcome.x_t1());
  std::vector<Vec3>& free = outcome.v.free;
  const std::vector<Vec3>& mean = outcome.v.mean;
  double b = 0.0, c = 0.0;
  for (std::size_t i = 0; i < in.n(); ++i) {
    if (!(in.inv_mass[i] > 0.0)) continue;
    const Vec3 d = free[i] - mean[i];
    b += in.particles.mass[i] * d.dot(v_end[i] - d - frame);
    c += 0.5 * in.particles.mass[i] * d.squaredNorm();
  }
  if (!(c > 0.0)) return 0.0;
  const double least = -0.5 * b / c;  // where the energy is least
  const double square = least * least - (gain - b - c) / c;
  const double kept = std::clamp(square > 0.0 ? least + std::sqrt(square) : least, 0.0, 1.0);
  std::vector<Vec3> before;
  if (notes) before = free;
  for (std::size_t i = 0; i < in.n(); ++i) free[i] = mean[i] + kept * (free[i] - mean[i]);
  if (notes) outcome.parting.ends.given["tempering"] += detail::given(in, before, free, 1.0);
  return b * (1.0 - kept) + c * (1.0 - kept * kept);
}

}  // namespace

// The longest step that is stable from the present state, s, at most h; 0: no step is stable.
double Simulation::Parts::longest_step(double h) {
  if (methods.traits.any_step) return h;
  input.particles.x = state.x;
  input.particles.v = state.v;
  input.t0 = state.time;
  input.t1 = state.time + h;
  input.h = h;
  std::vector<Vec3> x_t1(input.x_t0.size());
  detail::hold_particles(scene, built, state, input, x_t1);
  return kExplicitSafety *
         methods.integrator->stable_step(input.particles, state.time, h / kExplicitSafety);
}

// An unstable start is the input's fault.
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
        fmt::format("solver.integrator: \"{}\" is stable up to {:.3g} s here, the scene has {:.3g} "
                    "s; set time.steps_per_frame to {}",
                    name, stable, h,
                    static_cast<long long>(std::ceil(scene.time.steps_per_frame * h / stable))));
}

// The length of a step, at most h, that is stable for the integrator and the contacts, and in which
// bodies turn along their true paths, s.
double Simulation::Parts::stable_step(double h, double target) {
  h = turning.longest_step(built, state.time, h);
  h = detail::longest_turn(scene, built, state, h);
  double stable = longest_step(h);
  if (!(stable >= h) && scene.solver.refuse_unstable_step)
    throw SimulationFailed(
        FailureKind::unstable_step,
        fmt::format("unstable step at {} s: {} is stable up to {:.3g} s, the step has {:.3g} "
                    "s; the scene refuses to divide it",
                    state.time, scene.solver.integrator, stable, h));
  if (!methods.traits.is_implicit)
    stable = std::min(
        stable, kExplicitSafety *
                    methods.response->stable_step(detail::contact_inv_mass(input.particles.mass)));
  if (stable >= h) return h;
  const double left = target - state.time;
  return std::min(h, left / std::ceil(left / stable));
}

void Simulation::Parts::attempt_step(double h, double t1, bool may_shorten) {
  const bool tries = may_shorten && attempts.lengths.size() == 1 && state.given_strain == 0.0;
  input.hopeless_strain = tries && !methods.untangling() ? detail::StrainGuard::kHopeless
                                                         : std::numeric_limits<double>::infinity();
  input.t0 = state.time;
  input.t1 = t1;
  input.h = h;
  input.nominal_h = nominal_step();
  input.settles = settles();
  std::vector<Pinch> pinches = state.pinches;
  methods.pinches.begin_attempt();
  do {
    outcome = {};
    detail::Course course = detail::begin_step(scene, built, state, input);
    course.pinches = std::move(pinches);
    expect_motion(course);
    hold_pinched(course);
    outcome = detail::attempt_step(methods, input, std::move(course));
    pinches = outcome.near.pinches;
  } while (outcome.near.pinches_more || slip_pinches());
  outcome.counts.add_to(result.counters);
}

// Before an attempt: the integrator may know better where free particles go than they would coast.
void Simulation::Parts::expect_motion(detail::Course& course) const {
  std::vector<Vec3>& mean = course.v_mean;
  if (!methods.integrator->expect(input.h, state.v, mean)) return;
  for (std::size_t i = 0; i < n(); ++i) {
    if (input.inv_mass[i] > 0.0)
      course.x_t1[i] = input.x_t0[i] + input.h * mean[i];
    else
      mean[i] = input.v_coasting[i];
  }
  if (input.followers != nullptr) input.followers->place(std::span(course.x_t1).first(n()));
}

// Before an attempt: pinched cloth goes where its surfaces take it.
void Simulation::Parts::hold_pinched(detail::Course& course) {
  methods.pinches.hold(input, course.x_t1, course.pinches);
  for (const Pinch& pinch : course.pinches)
    course.v_mean[pinch.vertex] = input.v_coasting[pinch.vertex];
  if (methods.untangler) methods.untangler->set_pinches(course.pinches);
}

// Whether pinched cloth slips, so that the attempt has to begin again.
bool Simulation::Parts::slip_pinches() {
  if (outcome.near.pinches.empty()) return false;
  const detail::Parting& parting = outcome.parting;
  const bool carried = methods.untangler && methods.untangler->carries_pinches();
  const bool slips =
      outcome.accepted()
          ? parting.over_strain &&
                methods.pinches.slip(methods.strain.measures(), input, parting.ends.x_t1)
          : carried && methods.pinches.join(parting.ends.collisions, input, parting.ends.x_t1);
  if (!slips) return false;
  ++result.counters["pinches_slipped"];
  return true;
}

// After an accepted part of a step of `planned` s. What was too long for the strain limit is so for
// the next part, too.
StepControl Simulation::Parts::next_control(StepControl control, double planned) const {
  if (control.halvings > 0 && !strain_guard.has_shortened()) {
    --control.halvings;
    control.h = std::min(2.0 * control.h, planned);
  }
  return control;
}

// Makes one accepted step towards the end of the nominal step. It is halved until an attempt is
// accepted.
void Simulation::Parts::make_step(StepControl control) {
  require_ieee_arithmetic();  // a program may have changed it since the last step
  // Targets are computed from whole numbers, so that steps do not drift and a resumed run meets
  // them.
  const double target = static_cast<double>(control.done + control.span) * nominal_step();
  const double planned = control.span * nominal_step();
  if (!methods.untangling() && sleep.sleeps(state, target)) {
    sleep_until(target, control.span);
    return;
  }
  attempts.lengths.clear();
  attempts.accepted = false;
  balance.begin();
  strain_guard.begin();
  const auto shorten = [&] {
    control.h *= 0.5;
    ++control.halvings;
    ++result.halvings;
  };
  for (;;) {
    control.h = stable_step(control.h, target);
    const bool to_target = control.h >= (target - state.time) * kAllThatIsLeft;
    const double t1 = to_target ? target : state.time + control.h;
    const double h = t1 - state.time;
    attempts.lengths.push_back(h);
    if (!(h > 0.0))
      throw SimulationFailed(FailureKind::stalled, "a step of " + std::to_string(control.h) +
                                                       " s is too short to advance the time of " +
                                                       std::to_string(state.time) + " s");
    const bool may_shorten = control.halvings + kLeftForClean < scene.time.max_halvings;
    attempt_step(h, t1, may_shorten);
    const bool once_more =
        attempts.lengths.size() == 1 && has_other_method(methods.traits, outcome.v);
    if (!outcome.accepted()) {
      note_rejection();
      if (control.halvings + 1 >= scene.time.max_halvings) name_cause();
      if (once_more) continue;
      if (control.halvings < scene.time.max_halvings) {
        shorten();
        continue;
      }
      if (!carry_jam()) give_up();
      control.h = planned;
      control.halvings = 0;
      continue;
    }
    if (gains_energy() && may_shorten && balance.wants_shorter()) {
      if (once_more)
        balance.begin();
      else
        shorten();
      continue;
    }
    if (strains_far(h, may_shorten)) {
      shorten();
      continue;
    }
    accept();
    state.control = state.time < target ? next_control(control, planned) : StepControl{};
    return;
  }
}

// The state stays as it is, at rest, and so do the contacts of the last step.
void Simulation::Parts::sleep_until(double target, int nominal_steps) {
  if (wrenches) wrenches->sleep(target - state.time, input.particles.mass, state.x, state.v);
  std::fill(state.v.begin(), state.v.end(), Vec3::Zero());
  state.acceleration = 0.0;
  last_motion = {};
  state.time = target;
  state.control = {};
  state.refined = false;
  attempts.given_up = false;
  result.counters["steps_asleep"] += nominal_steps;
  methods.integrator->accept({state.x, state.v, input.particles.mass, state.time});
  note_memory();
}

// Whether the attempt ends with energy that no force supplied.
bool Simulation::Parts::gains_energy() {
  if (!methods.traits.is_implicit || !methods.traits.any_step || methods.untangling()) return false;
  const auto scope = clock.measure("balance");
  std::vector<Vec3> v_end(n());
  detail::end_velocities(methods.traits, input, outcome, v_end);
  finish_velocities(v_end);
  std::vector<ContactImpulse> impulses;
  const auto find_impulses = [&] {
    if (outcome.v.answered && impulses.empty())
      methods.response->impulses(outcome.v.mean, impulses);
  };
  const auto work_of_anchors = [&]() -> std::optional<double> {
    if (!methods.traits.follows_energy) return std::nullopt;
    find_impulses();
    return anchor_work(methods, input, outcome, impulses);
  };
  if (!balance.weigh(methods.integrator->forces(),
                     {input.x_t0, outcome.x_t1(), input.particles.v, v_end, input.inv_mass,
                      input.particles.mass, input.t0, input.h, methods.program.total_force(),
                      work_of_anchors}))
    return false;
  if (outcome.v.answered && balance.gain() > balance.bound()) {
    find_impulses();
    double work = 0.0;
    for (const ContactImpulse& c : impulses) work += c.work_normal + c.work_friction;
    balance.stored(std::max(0.0, work));
  }
  // Between bodies and cloth it would cost momentum; there the next attempt is by the other method.
  if (balance.gain() > balance.bound() && methods.traits.follows_energy && built.solids.empty()) {
    balance.stored(temper(input, balance.gain(), v_end, methods.notes_stages, outcome));
    ++result.counters["tempered_steps"];
  }
  return balance.gain() > balance.bound();
}

// Whether the attempt of h s ends so far above the strain limit that a shorter one is worth it;
// `may`: a shorter one is allowed.
bool Simulation::Parts::strains_far(double h, bool may) {
  if (methods.untangling() && !methods.untangler->carries_pinches()) return false;
  detail::StrainTrial trial{.h = h, .given = state.given_strain, .may_shorten = may};
  if (outcome.parting.over_strain) {
    const auto scope = clock.measure("strain");
    trial.end = methods.strain.overshoot(outcome.x_t1().first(n()));
    if (detail::StrainGuard::is_far(trial.end)) trial.start = methods.strain.overshoot(state.x);
  }
  if (strain_guard.wants_shorter(trial)) return true;
  state.given_strain = strain_guard.given_after(trial);
  return false;
}

// Velocities of the end after the response, with those that follow. A dense layer hands what
// contacts and limits did to it after the solve on to the sparse one.
void Simulation::Parts::finish_velocities(std::span<Vec3> v) const {
  methods.response->finish(v);
  input.keep_followers(v);
  if (methods.layers.empty()) return;
  std::vector<Vec3> off(n(), Vec3::Zero());
  for (const std::int32_t i : methods.layers.nodes())
    if (input.inv_mass[i] > 0.0)
      off[i] = (outcome.x_t1()[i] - input.x_t0[i]) / input.h - outcome.v.mean[i];
  methods.layers.push_leaders(input.particles.mass, input.particles.inv_mass, off, v);
}

// Keeps the parts of a rejected attempt that the next one overwrites.
void Simulation::Parts::note_rejection() {
  detail::Parting& parting = outcome.parting;
  const detail::Rejection& why = *parting.rejection;
  RejectedAttempt& failed = attempts.rejected;
  failed.h = input.h;
  failed.not_finite = why.not_finite;
  failed.cause = why.not_finite >= 0
                     ? methods.names.vertex(why.not_finite) + " has no finite position"
                     : why.cause;
  failed.pairs = std::move(parting.ends.collisions);
  failed.x_t0 = input.x_t0;
  failed.x_t1 = std::move(failed.pairs.empty() ? parting.ends.x_t1 : parting.x_tested);
}

// Puts what brought the pairs of the last rejected attempt together, and what helps, before the
// words of the method.
void Simulation::Parts::name_cause() {
  RejectedAttempt& failed = attempts.rejected;
  if (failed.pairs.empty()) return;
  RecordedAttempt facts;
  facts.h = input.h;
  facts.inv_mass = input.inv_mass;
  facts.contacts = outcome.near.points;
  const detail::Inquiry inquiry(
      {scene, methods.names, failed, facts, state.v, built.cloth.surface.triangles});
  failed.cause = inquiry.blame() + " (" + failed.cause + ")";
}

// Where the scene carries tangled cloth on, a body that leaves cloth no room passes through it. The
// pairs that collided may be cloth on cloth alone: then the bodies are those near their particles.
bool Simulation::Parts::carry_jam() {
  const RejectedAttempt& failed = attempts.rejected;
  if (!scene.contact.carry_tangled || !methods.untangler || failed.pairs.empty()) return false;
  std::vector<ContactPoint> pairs = failed.pairs;
  std::set<std::int32_t> jammed;
  for (const ContactPoint& c : failed.pairs) jammed.insert(c.vertex.begin(), c.vertex.end());
  for (const ContactPoint& c : outcome.near.points)
    if (std::any_of(c.vertex.begin(), c.vertex.end(), [&](auto v) { return jammed.contains(v); }))
      pairs.push_back(c);
  if (!methods.untangler->carry_pinches(failed.pairs, outcome.near.pinches) &&
      !methods.untangler->carry_jam(pairs, failed.x_t0))
    return false;
  note_held_inside();
  state.tangles = methods.untangler->tangles();
  methods.validator.forget();
  return true;
}

// Particles that a handle has taken into a closed body, or a body that has run over them: what the
// scene prescribes crosses.
void Simulation::Parts::note_held_inside() {
  std::vector<std::int32_t> held;
  for (std::size_t i = 0; i < n(); ++i)
    if (!(input.inv_mass[i] > 0.0)) held.push_back(static_cast<std::int32_t>(i));
  for (const Pinch& pinch : outcome.near.pinches) std::erase(held, pinch.vertex);
  if (held.empty()) return;
  const int inside =
      detail::count_inside(methods.detection.joint_surface(), attempts.rejected.x_t1, held);
  if (inside == 0) return;
  double& most = result.counters["max_held_inside_bodies"];
  most = std::max(most, static_cast<double>(inside));
}

void Simulation::Parts::give_up() {
  attempts.given_up = true;
  const RejectedAttempt& failed = attempts.rejected;
  std::string cause = "no clean step at " + std::to_string(state.time) + " s after " +
                      std::to_string(scene.time.max_halvings) + " halvings: " + failed.cause;
  if (!failed.pairs.empty())
    cause += "; of " + std::to_string(failed.pairs.size()) +
             " pairs that still collide the first is " + methods.names.pair(failed.pairs[0]);
  throw SimulationFailed(failed.not_finite >= 0 ? FailureKind::not_finite : FailureKind::not_clean,
                         cause);
}

StepControl Simulation::Parts::control() const {
  if (state.control.h > 0.0) return state.control;
  const std::int64_t done = std::llround(state.time / nominal_step());
  const int span = joined.span(done, state.acceleration);
  return {done, span * nominal_step(), 0, span};
}

// The attempt becomes the state.
void Simulation::Parts::accept() {
  if constexpr (detail::kValidatesSteps)
    detail::validate_accepted(methods.validator, methods.detection.searched(), methods.names,
                              state.step);
  carry_proof();
  std::vector<double>& mass = input.particles.mass;
  ledger.accept(outcome);
  if (wrenches) wrenches->begin_step(methods, input, outcome);
  methods.response->accept(outcome.x_t1());
  count_substitutes();
  balance.accept();
  detail::end_velocities(methods.traits, input, outcome, state.v);
  std::copy_n(outcome.x_t1().begin(), n(), state.x.begin());
  note_motion();
  if (wrenches) wrenches->set_velocities(state.v);
  methods.strain.finish(detail::limit_step(input), mass, state.x, state.v);
  if (wrenches) wrenches->finish_strain(state.v);
  finish_velocities(state.v);
  if (wrenches) {
    wrenches->finish_response(state.v);
    wrenches->end_step();
  }
  state.acceleration = joined.acceleration(input.particles.v, state.v, input.h);
  // Cloth that slept until now has to be still for long again before it sleeps.
  state.still = sleep.still_after(sleep.is_due(state) ? 0.0 : state.still, state.v, input.h);
  note_bodies(outcome.x_t1());
  if (water) wet(mass);
  state.pinches = outcome.near.pinches;
  state.time = input.t1;
  state.refined = false;
  ++state.step;
  if (attempts.lengths.size() > 1) ++result.retried_steps;
  methods.integrator->accept({state.x, state.v, mass, state.time});
  note_memory();
  note_strain();
  attempts.accepted = true;
  attempts.given_up = false;
  if (methods.untangling()) continue_untangling();
}

// Water spreads and drops onto the cloth.
void Simulation::Parts::wet(std::vector<double>& mass) {
  std::vector<double> before;
  if (wrenches) before = mass;
  water->advance(state.time, input.h, state, mass);
  if (wrenches) wrenches->change_mass(before, mass, state.x, state.v);
}

// Methods that acted in place of those that the scene names.
void Simulation::Parts::count_substitutes() {
  const std::string_view other = methods.response->substitute();
  if (!other.empty() && !(outcome.near.points.empty() && outcome.met.empty()))
    ++result.counters[fmt::format("substituted_{}_by_{}", scene.contact.response, other)];
}

std::vector<StepContact> detail::step_contacts(const Response& response,
                                               const detail::StepOutcome& outcome) {
  using Key = std::pair<std::array<std::int32_t, 4>, std::array<double, 4>>;
  std::vector<StepContact> contacts;
  std::map<Key, std::size_t> index;
  for (const auto* list : {&outcome.near.points, &outcome.met})
    for (const ContactPoint& c : *list)
      if (index.emplace(Key{c.vertex, c.weight}, contacts.size()).second)
        contacts.push_back({c, c.normal.dot(relative(c, outcome.x_t1())), Vec3::Zero()});
  std::vector<ContactImpulse> impulses;
  response.impulses(outcome.v.mean, impulses);
  for (const ContactImpulse& impulse : impulses)
    if (const auto at = index.find({impulse.vertex, impulse.weight}); at != index.end())
      contacts[at->second].impulse += impulse.impulse;
  return contacts;
}

}  // namespace selvedge
