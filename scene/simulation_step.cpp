// SPDX-License-Identifier: MIT
//
// One try of a step: forces, contacts, strain limit, collisions, fail-safe.
#include <selvedge/scene/detail/handles.h>
#include <selvedge/scene/detail/simulation_parts.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace selvedge {
namespace {

// Solves of one step that settle its contacts. Four are enough nearly always, but where a stack
// lands each finds one more layer, and each round of collisions begins anew. One that gets fewer
// than it needs never comes to rest, and where an impact is cut off rounding decides how it ends.
// What is still open is left to the next step.
constexpr int kMaxSolves = 48;

// While contacts are open, the tolerance is this many times the scene's; a hundred misleads.
constexpr double kLooser = 10.0;

// Further solves, because cloth would pass through something that had not been a contact before.
constexpr int kMaxCollisionSolves = 3;

// Strain limiting and collision response disturb each other: rounds of both in one step.
constexpr int kStrainRounds = 3;

}  // namespace

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

LimitStep Simulation::Parts::limit_step(double h) const {
  return {std::span(x_t0).first(n()), std::span(inv_mass).first(n()), h};
}

bool Simulation::Parts::strain_is_tolerated() {
  const auto x = std::span(x_t1).first(n());
  constexpr double any = std::numeric_limits<double>::infinity();
  return reach.keeps_below(x, any, detail::strain_tolerance) ||
         strain.measure(x).residual <= detail::strain_tolerance;
}

bool Simulation::Parts::limits_hold() {
  const auto scope = clock.measure("plan");
  return reach.keeps_limits(std::span(x_t1).first(n()));
}

void Simulation::Parts::limit_strain(double h) {
  if (!strain_stage.acts()) return;
  double& sweeps = result.counters["strain_sweeps"];
  if (limits_hold()) return tell("strain limit");
  const auto scope = clock.measure("strain");
  const PhaseClock::Scope busy(reach.busy());
  const StrainReport report = strain_stage.limit(limit_step(h), std::span(x_t1).first(n()));
  sweeps += report.sweeps;
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
    integrator->begin({particles, state.time, h, !contacts.empty() || untangling()},
                      {v_t1, v_free});
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
          integrator->solve(untangling() ? untangler->with_drive(terms, mass) : terms,
                            {v_t1, v_free}, answered_in_solve ? looser : 1.0);
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
    limit_strain(h);
    if (!find_hits() || ++collision_solves > kMaxCollisionSolves) return;
    response->add(hits);
  }
}

// From the velocities of the solve or the explicit step to ends that the response has corrected.
void Simulation::Parts::answer_contacts(double h) {
  set_end_from_velocity(h);
  strain_stage.begin();
  if (!method.ends_with_mean) std::copy_n(x_t1.begin(), n(), x_free.begin());
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
    integrator->begin({particles, state.time, h, !contacts.empty() || untangling()},
                      {v_t1, v_free});
    if (untangling()) untangle_velocities();
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
    limit_strain(h);
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
  if (method.is_implicit)
    solve_implicit(h);
  else if (!step_explicit(h))
    return false;
  if (!is_finite()) return false;
  for (int round = 0;; ++round) {
    if (!resolve_collisions(h)) return false;
    if (!strain_stage.bounds_strain() || round + 1 >= kStrainRounds) return true;
    if (strain_is_tolerated()) return true;
    limit_strain(h);
    find_hits();
  }
}

// What contacts and limits moved the end of a step is added to the velocity that the integrator has
// there: free flight keeps its order, and whatever stops a particle stops it.
void Simulation::Parts::set_velocities(double h, std::span<Vec3> v) const {
  for (std::size_t i = 0; i < n(); ++i) {
    const bool mean = method.ends_with_mean || !(inv_mass[i] > 0.0);
    v[i] = mean ? Vec3((x_t1[i] - x_t0[i]) / h) : Vec3(v_free[i] + (x_t1[i] - x_free[i]) / h);
  }
}

// Whether the try ends with energy that nobody gave.
bool Simulation::Parts::gains_energy(double h) {
  if (!method.is_implicit || !method.any_step || untangling()) return false;
  const auto scope = clock.measure("balance");
  v_end.resize(n());
  set_velocities(h, v_end);
  response->finish(v_end);
  if (!balance.weigh(integrator->forces(),
                     {x_t0, x_t1, state.v, v_end, inv_mass, mass, state.time, h}))
    return false;
  if (answered_in_solve && balance.gain() > balance.bound()) {
    impulses.clear();
    response->impulses(v_t1, impulses);
    double work = 0.0;
    for (const ContactImpulse& c : impulses) work += c.work_normal + c.work_friction;
    balance.stored(std::max(0.0, work));
  }
  return balance.gain() > balance.bound();
}

// The velocity at the end goes along with that of the step.
void Simulation::Parts::untangle_velocities() {
  std::vector<Vec3>& before = v_before_untangling;
  before.assign(v_t1.begin(), v_t1.end());
  untangler->set_velocities(inv_mass, v_t1);
  for (std::size_t i = 0; i < n(); ++i) v_free[i] += v_t1[i] - before[i];
}

void Simulation::Parts::note_memory() {
  state.memory.clear();
  integrator->save_memory(state.memory);
}

void Simulation::Parts::accept(double h, double t1) {
  ledger.accept(response_step(h), *response, v_t1, answered_in_solve);
  balance.accept();
  set_velocities(h, state.v);
  std::copy_n(x_t1.begin(), n(), state.x.begin());
  strain_stage.finish(limit_step(h), mass, state.x, state.v);
  response->finish(state.v);
  note_bodies(x_t1);
  if (water) water->advance(state.time, h, state, mass);
  if (water) particles.mass = mass;
  state.time = t1;
  ++state.step;
  ++result.steps;
  integrator->accept({state.x, state.v, mass, state.time});
  note_memory();
  note_strain();
  if (untangling()) go_on_untangling();
}

}  // namespace selvedge
