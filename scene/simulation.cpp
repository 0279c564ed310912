// SPDX-License-Identifier: MIT
#include <selvedge/core/integrator.h>
#include <selvedge/core/strain_limiter.h>
#include <selvedge/scene/detail/handles.h>
#include <selvedge/scene/detail/scene_forces.h>
#include <selvedge/scene/detail/step_ledger.h>
#include <selvedge/scene/detection.h>
#include <selvedge/scene/phase_clock.h>
#include <selvedge/scene/simulation.h>
#include <selvedge/scene/untangle.h>
#include <selvedge/scene/vertex_flags.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace selvedge {
namespace {

// Solves of one step that settle its contacts. Four are enough nearly always, but a stack that gets
// fewer than it needs never comes to rest. What is still open is left to the next step.
constexpr int kMaxSolves = 12;

// While contacts are open, the tolerance is this many times the scene's; a hundred misleads.
constexpr double kLooser = 10.0;

// Further solves, because cloth would pass through something that had not been a contact before.
constexpr int kMaxCollisionSolves = 3;

constexpr double kStrainTolerance = 1e-3;  // strain above the limit that the limiter may leave
constexpr int kStrainSweeps = 200;

// Strain limiting and collision response disturb each other: rounds of both in one step.
constexpr int kStrainRounds = 3;

// A step that covers this share of the time that is left goes to its end.
constexpr double kAllThatIsLeft = 1.0 - 1e-9;

// Share of the stable step that the explicit integrator uses.
constexpr double kExplicitSafety = 0.9;

double max_norm(std::span<const Vec3> v) {
  double largest = 0.0;
  for (const Vec3& u : v) largest = std::max(largest, u.squaredNorm());
  return std::sqrt(largest);
}

// The limiter may leave kStrainTolerance: it aims that much below, so that the limit itself holds.
std::vector<double> limiter_targets(const std::vector<double>& limits) {
  std::vector<double> targets = limits;
  for (double& limit : targets) limit = std::max(limit - kStrainTolerance, 0.5 * limit);
  return targets;
}

}  // namespace

struct Simulation::Parts {
  Scene scene;
  BuiltScene built;
  std::vector<Triangle> body_triangles;
  PhaseClock clock;
  Detection detection;
  StrainLimiter limiter;
  std::optional<ImplicitEuler> implicit;
  std::optional<SymplecticEuler> symplectic;
  std::unique_ptr<Response> response;
  std::unique_ptr<FailSafe> fail_safe;

  SimulationState state;
  Particles particles;           // the same x and v, with masses
  std::vector<double> mass;      // of particles
  std::vector<double> inv_mass;  // of particles and body vertices (0)
  std::vector<Vec3> x_t0, x_t1;  // particles, then body vertices
  std::vector<Vec3> body_step;   // x_t1 - x_t0 of the body vertices
  std::vector<Vec3> body_x;      // of the body vertices at the state's time
  std::vector<Vec3> v_t1, predicted;
  std::vector<ContactPoint> contacts, hits;
  bool answered_in_solve = false;  // the last solve had terms of the response
  detail::StepLedger ledger;
  RunResult result;
  std::string trouble;         // why the last try failed
  std::vector<Vec3> unparted;  // x_t1 that the fail-safe was given last
  std::vector<double> tried;   // s, of the last step
  FailedTry failed;
  VertexNames names;
  std::optional<Untangler> untangler;
  const StepTrace* trace = nullptr;

  Parts(const Scene& s, BuiltScene b, const Methods& methods)
      : scene(s),
        built(std::move(b)),
        detection(scene, built, methods, clock),
        limiter(built.cloth.springs, limiter_targets(built.cloth.strain_limit),
                built.cloth.surface.vertices.size()),
        response(make_method(methods.responses, scene.contact.response, "contact.response",
                             scene.contact.response_config)),
        fail_safe(make_method(methods.fail_safes, scene.contact.fail_safe, "contact.fail_safe")),
        names(scene, built) {
    detail::refuse_bad_handles(scene, built);
    detail::refuse_unfit_response(scene, *response, built.cloth.mass, nominal_step(),
                                  scene.solver.integrator == "symplectic_euler");
    const std::size_t n = built.cloth.surface.vertices.size();
    state.x = built.cloth.surface.vertices;
    state.v = built.velocity;
    mass = built.cloth.mass;
    particles.mass = mass;
    particles.inv_mass.assign(n, 0.0);
    body_triangles.assign(detection.body_triangles().begin(), detection.body_triangles().end());
    const std::size_t m = detection.body_vertices();
    inv_mass.assign(n + m, 0.0);
    x_t0.resize(n + m);
    x_t1.resize(n + m);
    body_step.resize(m);
    if (scene.solver.integrator == "symplectic_euler")
      symplectic.emplace(detail::make_forces(scene, built), n);
    else
      implicit.emplace(detail::make_forces(scene, built), n,
                       ImplicitConfig{scene.solver.tolerance, scene.solver.max_iterations});
    place_bodies(state.time, x_t0);
    note_bodies(x_t0);
    refuse_crossing_start();
    note_strain();
  }

  std::size_t n() const { return state.x.size(); }

  void place_bodies(double time, std::vector<Vec3>& x) const {
    for (std::size_t b = 0; b < built.bodies.size(); ++b)
      built.bodies[b]->positions(time, std::span(x).subspan(n() + detection.body_begin()[b],
                                                            built.bodies[b]->vertex_count()));
  }

  void note_bodies(const std::vector<Vec3>& x) {
    body_x.assign(x.begin() + static_cast<std::ptrdiff_t>(n()), x.end());
  }

  bool bodies_move(double t0, double t1) const {
    return std::any_of(built.bodies.begin(), built.bodies.end(),
                       [&](const auto& body) { return !body->is_static(t0, t1); });
  }

  void look_at_state() {
    std::copy(state.x.begin(), state.x.end(), x_t0.begin());
    place_bodies(state.time, x_t0);
    detection.set_motion(x_t0, x_t0, bodies_move(state.time, state.time),
                         StepTimes{state.time, state.time});
  }

  Crossings crossings_now() {
    look_at_state();
    const auto scope = clock.measure("verify");
    return detection.find_crossings();
  }

  void refuse_crossing_start() {
    const Crossings found = crossings_now();
    if (scene.contact.untangle_start) return start_untangling();
    refuse_crossings(found, scene.contact.self);
  }

  bool untangling() const { return untangler && untangler->active(); }
  void start_untangling();
  void go_on_untangling();
  void resume_untangling();

  void note_strain() {
    const StrainReport strain = limiter.measure(state.x);
    result.max_stretch = std::max(result.max_stretch, strain.max_strain);
    result.strain_residual =
        std::max(result.strain_residual, std::max(0.0, strain.residual - kStrainTolerance));
  }

  std::vector<std::uint8_t> flags() const {
    return vertex_flags({built.cloth, state.x, contacts, state.tangles.list,
                         untangler && untangler->report().given_up, kStrainTolerance});
  }

  void verify_frame() {
    count_flags(flags(), result.flags);
    if (untangling()) return;  // has just been looked at, and the result counts it
    const Crossings found = crossings_now();
    result.worst_self_intersections =
        std::max(result.worst_self_intersections, static_cast<int>(found.self.size()));
    result.worst_body_intersections =
        std::max(result.worst_body_intersections, static_cast<int>(found.body.size()));
    result.clean = result.clean && found.self.empty() && found.body.empty();
  }

  // How much of its rest gap a contact lacks at the start of a step, so of all states but the last.
  void note_lacks() {
    double& largest = result.counters["max_gap_lack_m"];
    for (const ContactPoint& c : contacts) largest = std::max(largest, c.rest_gap - c.gap);
  }

  // Sets masses for the step and the prescribed end positions of held particles.
  void hold_particles(double t0, double t1, double h);
  ResponseStep response_step(double h) const {
    return {{x_t0, inv_mass, n(), h}, mass, body_step, state.v, predicted, implicit.has_value()};
  }
  void set_end_from_velocity(double h);
  bool is_finite();
  void solve_implicit(double h);
  bool step_explicit(double h);
  bool bears_contacts(double h);
  void answer_contacts(double h);
  void limit_strain();
  bool find_hits();
  bool resolve_collisions(double h);
  bool try_step(double h, double t1);
  double nominal_step() const { return 1.0 / (scene.time.fps * scene.time.steps_per_frame); }
  StepControl control() const;
  double stable_step(double h, double target);
  void make_step(StepControl control);
  void note_failure(double h);
  [[noreturn]] void give_up();
  void tell(const char* stage, std::span<const ImplicitTerm> terms = {}) const {
    if (trace) trace->stage({stage, x_t1, hits, terms, v_t1});
  }
  void accept(double h, double t1);
};

void Simulation::Parts::hold_particles(double t0, double t1, double h) {
  for (std::size_t i = 0; i < n(); ++i) particles.inv_mass[i] = 1.0 / mass[i];
  v_t1 = state.v;
  detail::visit_held(scene, built, t0, t1, [&](std::int32_t i, const Vec3& end) {
    particles.inv_mass[i] = 0.0;
    v_t1[i] = (end - state.x[i]) / h;
    x_t1[i] = end;
  });
  std::copy(particles.inv_mass.begin(), particles.inv_mass.end(), inv_mass.begin());
}

// Held particles keep the end position that was prescribed, to the bit.
void Simulation::Parts::set_end_from_velocity(double h) {
  for (std::size_t i = 0; i < n(); ++i)
    if (inv_mass[i] > 0.0) x_t1[i] = x_t0[i] + h * v_t1[i];
}

bool Simulation::Parts::is_finite() {
  for (std::size_t i = 0; i < n(); ++i)
    if (!x_t1[i].allFinite()) {
      failed.not_finite = static_cast<std::int32_t>(i);
      trouble = names.vertex(failed.not_finite) + " has no finite position";
      hits.clear();
      return false;
    }
  return true;
}

void Simulation::Parts::limit_strain() {
  if (!scene.solver.strain_limiter) return;
  const auto scope = clock.measure("strain");
  const StrainReport report = limiter.apply(std::span(inv_mass).first(n()), kStrainTolerance,
                                            kStrainSweeps, std::span(x_t1).first(n()));
  result.counters["strain_sweeps"] += report.sweeps;
  tell("strain limit");
}

bool Simulation::Parts::find_hits() {
  if (!detection.candidates_cover()) {
    detection.find_candidates();
    result.counters["candidate_rebuilds"] += 1;
  }
  detection.find_collisions(hits);
  return !hits.empty();
}

// Step 1 of the plan: forces, contacts and friction give the end-of-step state; collisions that are
// found on the way to it become contacts of another solve.
void Simulation::Parts::solve_implicit(double h) {
  {
    const auto scope = clock.measure("forces");
    implicit->assemble(particles, state.time, h);
    response->begin(response_step(h));
    response->add(contacts);
  }
  answered_in_solve = false;
  int collision_solves = 0;
  double looser = kLooser;
  for (int solve = 0; solve < kMaxSolves + kMaxCollisionSolves; ++solve) {
    double residual = 0.0;
    // A response without terms does all of its work after the solve, which stays as it is.
    if (const auto terms = response->terms(); solve == 0 || answered_in_solve || !terms.empty()) {
      const auto scope = clock.measure("solve");
      answered_in_solve = !terms.empty();
      const SolveReport report =
          implicit->solve(untangling() ? untangler->with_drive(terms, mass) : terms, v_t1,
                          answered_in_solve ? looser : 1.0);
      result.counters["solves"] += 1;
      result.counters["solver_iterations"] += report.iterations;
      result.counters["solves_not_converged"] += report.converged ? 0 : 1;
      residual = report.residual;
      if (trace) set_end_from_velocity(h);
      tell(collision_solves == 0 ? "solve" : "collision solve", terms);
    }
    if (response->update(v_t1) && solve + 1 < kMaxSolves) continue;
    if (std::exchange(looser, 1.0) > 1.0 && residual > scene.solver.tolerance) continue;
    answer_contacts(h);
    if (!is_finite()) return;
    limit_strain();
    if (!find_hits() || ++collision_solves > kMaxCollisionSolves) return;
    response->add(hits);
  }
}

// From the velocities of the solve or the explicit step to ends that the response has corrected.
void Simulation::Parts::answer_contacts(double h) {
  set_end_from_velocity(h);
  const auto scope = clock.measure("response");
  response->correct(x_t1);
  ledger.corrected(std::span(x_t1).first(n()));
  tell("contacts");
}

bool Simulation::Parts::bears_contacts(double h) {
  const double stable = response->stable_step();
  if (h <= stable) return true;
  trouble = "the contacts of " + scene.contact.response + " bear explicit steps below " +
            std::to_string(stable) + " s, this one has " + std::to_string(h) + " s";
  hits.clear();
  return false;
}

// Collisions that are found on the way become contacts of another answer. False: the step has to be
// shorter.
bool Simulation::Parts::step_explicit(double h) {
  {
    const auto scope = clock.measure("forces");
    symplectic->step(particles, state.time, h, v_t1);
    if (untangling()) untangler->set_velocities(inv_mass, v_t1);
  }
  if (trace) set_end_from_velocity(h);
  tell("explicit step");
  answered_in_solve = false;
  response->begin(response_step(h));
  response->add(contacts);
  for (int round = 0;; ++round) {
    if (!bears_contacts(h)) return false;
    answer_contacts(h);
    if (!is_finite()) return false;
    limit_strain();
    if (!find_hits() || round >= kMaxCollisionSolves) return true;
    response->add(hits);
  }
}

// The fail-safe until nothing collides. False: the step has to be shorter.
bool Simulation::Parts::resolve_collisions(double h) {
  if (hits.empty()) return true;
  const ResponseStep step = response_step(h);
  fail_safe->begin(step, detection);
  const std::vector<Vec3> before(x_t1.begin(), x_t1.begin() + static_cast<std::ptrdiff_t>(n()));
  while (!hits.empty()) {
    bool resolved = false;
    unparted = x_t1;
    {
      const auto scope = clock.measure("response");
      resolved = fail_safe->resolve(hits, x_t1);
    }
    tell("fail-safe");
    if (!resolved) {
      trouble = fail_safe->trouble();
      return false;
    }
    find_hits();
  }
  ledger.parted(step, before, std::span(x_t1).first(n()));
  return true;
}

bool Simulation::Parts::try_step(double h, double t1) {
  const double t0 = state.time;
  hits.clear();
  particles.x = state.x;
  particles.v = state.v;
  std::copy(state.x.begin(), state.x.end(), x_t0.begin());
  place_bodies(t0, x_t0);
  place_bodies(t1, x_t1);
  for (std::size_t j = 0; j < body_step.size(); ++j) body_step[j] = x_t1[n() + j] - x_t0[n() + j];
  hold_particles(t0, t1, h);
  for (std::size_t i = 0; i < n(); ++i)
    if (inv_mass[i] > 0.0) v_t1[i] += h * scene.gravity;
  predicted = v_t1;
  set_end_from_velocity(h);
  detection.set_motion(x_t0, x_t1, bodies_move(t0, t1), StepTimes{t0, t1});
  detection.find_candidates();
  detection.find_proximities(contacts);
  result.counters["contacts"] += static_cast<double>(contacts.size());
  if (trace) trace->begin({h, x_t0, x_t1, inv_mass, contacts});
  if (untangling()) untangler->begin(predicted, body_step, h);

  note_lacks();
  ledger.begin();
  if (implicit)
    solve_implicit(h);
  else if (!step_explicit(h))
    return false;
  if (!is_finite()) return false;
  for (int round = 0;; ++round) {
    if (!resolve_collisions(h)) return false;
    if (!scene.solver.strain_limiter || round + 1 >= kStrainRounds) return true;
    if (limiter.measure(std::span(x_t1).first(n())).residual <= kStrainTolerance) return true;
    limit_strain();
    find_hits();
  }
}

void Simulation::Parts::accept(double h, double t1) {
  ledger.accept(response_step(h), *response, v_t1, answered_in_solve);
  for (std::size_t i = 0; i < n(); ++i) state.v[i] = (x_t1[i] - x_t0[i]) / h;
  std::copy_n(x_t1.begin(), n(), state.x.begin());
  response->finish(state.v);
  note_bodies(x_t1);
  state.time = t1;
  ++state.step;
  ++result.steps;
  if (implicit) implicit->accept({state.x, state.v, mass, state.time});
  if (symplectic) symplectic->accept({state.x, state.v, mass, state.time});
  note_strain();
  if (untangling()) go_on_untangling();
}
void Simulation::Parts::start_untangling() {
  const std::vector<EdgeCrossing> crossings = detection.find_edge_crossings();
  untangler.emplace(detection.joint_surface(), UntangleConfig{});
  if (const std::int32_t v = untangler->enclosed(x_t0, crossings); v >= 0)
    throw std::invalid_argument(names.vertex(v) +
                                " and all the cloth that hangs on it lie inside a closed body at "
                                "the start; move the piece out of it");
  untangler->start(x_t0, crossings);
  detection.set_excluded(&untangler->excluded());
  state.tangles = untangler->tangles();
}
void Simulation::Parts::resume_untangling() {
  look_at_state();
  untangler->resume(state.tangles, x_t0, detection.find_edge_crossings());
}
void Simulation::Parts::go_on_untangling() {
  untangler->finish(state.v);
  look_at_state();
  const auto scope = clock.measure("untangle");
  untangler->update(x_t0, detection.find_edge_crossings(), state.time);
  state.tangles = untangler->tangles();
  if (!untangler->report().given_up || scene.contact.carry_tangled) return;
  throw SimulationFailed(FailureKind::not_clean,
                         "no way was found to untangle the cloth: " + crossings_now().sentence());
}

// Explicit steps keep within the integrator's bound.
double Simulation::Parts::stable_step(double h, double target) {
  if (!symplectic) return h;
  const double left = target - state.time;
  particles.x = state.x;
  particles.v = state.v;
  hold_particles(state.time, target, left);
  const double stable =
      kExplicitSafety * std::min(symplectic->stable_step(particles),
                                 response->stable_step(detail::contact_inv_mass(mass)));
  return std::min(h, left / std::ceil(left / stable));
}

// One accepted step towards the end of the nominal step; halved until it is clean.
void Simulation::Parts::make_step(StepControl control) {
  // Targets are computed from whole numbers, so that steps do not drift and a resumed run meets
  // them.
  const double target = static_cast<double>(control.done + 1) * nominal_step();
  tried.clear();
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
  parts_->state = std::move(state);
  parts_->place_bodies(parts_->state.time, parts_->x_t0);
  parts_->note_bodies(parts_->x_t0);
  if (parts_->untangler) parts_->resume_untangling();
}

const std::vector<double>& Simulation::tried() const { return parts_->tried; }
const FailedTry& Simulation::failed_try() const { return parts_->failed; }
const VertexNames& Simulation::names() const { return parts_->names; }
void Simulation::set_trace(const StepTrace* trace) { parts_->trace = trace; }
std::vector<std::uint8_t> Simulation::flags() const { return parts_->flags(); }
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
