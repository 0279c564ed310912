// SPDX-License-Identifier: MIT
#include <selvedge/core/parallel.h>
#include <selvedge/simulation/detail/step.h>
#include <selvedge/simulation/detail/step_ledger.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace selvedge::detail {
namespace {

// Solves of one step that settle its contacts. Four nearly always suffice. Where a stack lands,
// each solve finds one more layer, and each round of collisions starts again. A step that gets
// fewer than it needs never comes to rest: where an impact is cut off, rounding decides how it
// ends. The next step continues with the rest.
constexpr int kMaxSolves = 48;

// While contacts are open, the tolerance is a multiple of the scene's. The first solve needs least
// accuracy to find which contacts carry load. Factor of the first solve, its change from solve to
// solve, and its least value.
constexpr double kLoosest = 30.0, kTightening = 0.6, kLooser = 10.0;

// Further solves because cloth would pass through something that was no contact before.
constexpr int kMaxCollisionSolves = 3;

// Strain limits and collision response disturb each other: rounds of both in one step.
constexpr int kStrainRounds = 6;

constexpr std::size_t kEndGrain = 2048;  // particles per task

void trace_stage(const StepMethods& m, const char* stage, const StepAttempt& a,
                 std::span<const ImplicitTerm> terms = {}) {
  if (m.trace) m.trace->stage({stage, a.x_t1, a.collisions, terms, a.v_mean});
}

std::span<Vec3> particle_ends(const StepInput& in, StepAttempt& a) {
  return std::span(a.x_t1).first(in.n());
}

// Held particles keep the prescribed end position, to the bit.
void move_by_velocity(const StepInput& in, StepAttempt& a) {
  parallel_for(in.n(), kEndGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (in.inv_mass[i] > 0.0) a.x_t1[i] = in.x_t0[i] + in.h * a.v_mean[i];
  });
  if (in.followers != nullptr) in.followers->place(particle_ends(in, a));
}

std::int32_t first_not_finite(const StepInput& in, const StepAttempt& a) {
  const double count = parallel_sum(in.n(), kEndGrain, [&](std::size_t begin, std::size_t end) {
    double own = 0.0;
    for (std::size_t i = begin; i < end; ++i)
      if (!a.x_t1[i].allFinite()) own += 1.0;
    return own;
  });
  if (count == 0.0) return -1;
  for (std::size_t i = 0; i < in.n(); ++i)
    if (!a.x_t1[i].allFinite()) return static_cast<std::int32_t>(i);
  return -1;
}

StepOutcome reject_not_finite(std::int32_t particle, StepAttempt& a) {
  a.collisions.clear();
  return {.accepted = false, .cause = {}, .not_finite = particle};
}

// -- contacts near the start ----------------------------------------------------------------------

void find_contacts(StepMethods& m, const StepInput& in, StepAttempt& a) {
  m.detection.set_motion(in.x_t0, a.x_t1, in.bodies_move, StepTimes{in.t0, in.t1});
  m.detection.find_candidates();
  m.detection.find_proximities(a.contacts);
  a.counts.contacts = a.contacts.size();
  for (const ContactPoint& c : a.contacts)
    a.counts.max_gap_violation = std::max(a.counts.max_gap_violation, c.rest_gap - c.gap);
}

// -- forces ---------------------------------------------------------------------------------------

void begin_forces(StepMethods& m, const StepInput& in, StepAttempt& a) {
  const auto scope = m.clock.measure("forces");
  a.touched.clear();
  const bool everywhere =
      m.untangling() || (m.traits.follows_energy && m.sewing.goes_on(in.particles.x));
  if (!everywhere)
    for (const ContactPoint& c : a.contacts)
      for (const std::int32_t i : c.vertex)
        if (static_cast<std::size_t>(i) < in.n()) a.touched.push_back(i);
  m.integrator->begin({in.particles, in.t0, in.h, everywhere || !a.contacts.empty(), a.touched},
                      {a.v_mean, a.v_free});
}

void begin_response(StepMethods& m, const StepInput& in, const StepAttempt& a) {
  const auto scope = m.clock.measure("response");
  ResponseStep step = response_step(m, in);
  if (!a.contacts.empty()) step.unbalanced = m.integrator->unbalanced(a.v_mean);
  m.response->begin(step);
  m.response->add(a.contacts);
}

std::span<const ImplicitTerm> response_terms(StepMethods& m) {
  const auto scope = m.clock.measure("response");
  return m.response->terms();
}

bool update_response(StepMethods& m, StepAttempt& a) {
  const auto scope = m.clock.measure("response");
  return m.response->update(a.v_mean);
}

// One solve with these terms of the response; gives its residual.
double solve(StepMethods& m, const StepInput& in, StepAttempt& a,
             std::span<const ImplicitTerm> terms, double looser) {
  const auto scope = m.clock.measure("solve");
  a.answered_in_solve = !terms.empty();
  const SolveReport report = m.integrator->solve(
      m.untangling() ? m.untangler->with_drive(terms, in.particles.mass) : terms,
      {a.v_mean, a.v_free}, a.answered_in_solve ? looser : 1.0);
  ++a.counts.solves;
  a.counts.solver_iterations += report.iterations;
  a.counts.solver_bytes += report.bytes;
  a.counts.solves_not_converged += report.converged ? 0 : 1;
  return report.residual;
}

// -- answers on the end positions -----------------------------------------------------------------

void correct_ends(StepMethods& m, const StepInput& in, StepAttempt& a) {
  move_by_velocity(in, a);
  m.strain.begin();
  if (!m.traits.ends_with_mean) std::copy_n(a.x_t1.begin(), in.n(), a.x_free.begin());
  const auto scope = m.clock.measure("response");
  m.response->correct(a.x_t1);
  const auto ends = particle_ends(in, a);
  in.keep_followers(ends);
  a.x_corrected.assign(ends.begin(), ends.end());
  trace_stage(m, "contacts", a);
}

void limit_strain(StepMethods& m, const StepInput& in, StepAttempt& a) {
  if (!m.strain.acts()) return;
  const auto keep = [&](std::span<Vec3> ends) {
    in.keep_followers(ends);
    return in.followers != nullptr;
  };
  a.counts.strain_sweeps = std::max(a.counts.strain_sweeps, 0) +
                           m.strain.limit(limit_step(in), particle_ends(in, a), keep, m.clock);
  trace_stage(m, "strain limit", a);
}

void limit_strain_beside(StepMethods& m, const StepInput& in, StepAttempt& a) {
  const auto keep = [&](std::span<Vec3> ends) {
    in.keep_followers(ends);
    return in.followers != nullptr;
  };
  a.counts.strain_sweeps +=
      m.strain.limit_beside(limit_step(in), {a.parted, in.inv_mass}, a.x_t1, keep, m.clock);
  trace_stage(m, "strain limit", a);
}

void find_collisions(StepMethods& m, const StepInput& in, StepAttempt& a) {
  if (m.detection.renew_candidates()) ++a.counts.candidate_rebuilds;
  m.detection.find_collisions(a.collisions);
  if constexpr (kValidatesSteps)
    validate_attempt(m.validator, m.detection.searched(), m.names, in.step);
}

// Contacts, limits and a test of the paths that result.
void finish_ends(StepMethods& m, const StepInput& in, StepAttempt& a, StepOutcome& outcome) {
  correct_ends(m, in, a);
  if (const std::int32_t particle = first_not_finite(in, a); particle >= 0) {
    outcome = reject_not_finite(particle, a);
    return;
  }
  limit_strain(m, in, a);
  find_collisions(m, in, a);
}

void add_collisions_as_contacts(StepMethods& m, StepAttempt& a) {
  m.response->add(a.collisions);
  a.met.insert(a.met.end(), a.collisions.begin(), a.collisions.end());
}

// -- forces with contacts -------------------------------------------------------------------------

// Forces, contacts and friction give the end-of-step state. Collisions on the way to it become
// contacts of another solve.
StepOutcome solve_implicit(StepMethods& m, const StepInput& in, StepAttempt& a) {
  begin_forces(m, in, a);
  begin_response(m, in, a);
  StepOutcome outcome;
  int collision_solves = 0;
  double looser = kLoosest;
  for (int round = 0; round < kMaxSolves + kMaxCollisionSolves; ++round) {
    double residual = 0.0;
    // A response without terms does all of its work after the solve, so that one solve suffices.
    if (const auto terms = response_terms(m); round == 0 || a.answered_in_solve || !terms.empty()) {
      residual = solve(m, in, a, terms, looser);
      if (m.trace) move_by_velocity(in, a);
      trace_stage(m, collision_solves == 0 ? "solve" : "collision solve", a, terms);
    }
    if (update_response(m, a) && round + 1 < kMaxSolves) {
      if (looser > 1.0) looser = std::max(kLooser, kTightening * looser);
      continue;
    }
    if (std::exchange(looser, 1.0) > 1.0 && residual > m.scene.solver.tolerance) continue;
    finish_ends(m, in, a, outcome);
    if (!outcome.accepted || a.collisions.empty() || ++collision_solves > kMaxCollisionSolves)
      return outcome;
    add_collisions_as_contacts(m, a);
  }
  return outcome;
}

// The velocity at the end changes with the mean velocity of the step.
void drive_untangling(StepMethods& m, const StepInput& in, StepAttempt& a) {
  const std::vector<Vec3> before = a.v_mean;
  m.untangler->set_velocities(in.inv_mass, a.v_mean);
  for (std::size_t i = 0; i < in.n(); ++i) a.v_free[i] += a.v_mean[i] - before[i];
}

// The integrator computes the end; collisions on the way become contacts of another correction.
StepOutcome solve_explicit(StepMethods& m, const StepInput& in, StepAttempt& a) {
  begin_forces(m, in, a);
  if (m.untangling()) drive_untangling(m, in, a);
  if (m.trace) move_by_velocity(in, a);
  trace_stage(m, "explicit step", a);
  begin_response(m, in, a);
  StepOutcome outcome;
  for (int round = 0;; ++round) {
    if (const double stable = m.response->stable_step(); !(in.h <= stable)) {
      a.collisions.clear();
      return {.accepted = false,
              .cause = "the contacts of " + m.scene.contact.response +
                       " bear explicit steps below " + std::to_string(stable) +
                       " s, this one has " + std::to_string(in.h) + " s"};
    }
    finish_ends(m, in, a, outcome);
    if (!outcome.accepted || a.collisions.empty() || round >= kMaxCollisionSolves) return outcome;
    add_collisions_as_contacts(m, a);
  }
}

// -- collisions -----------------------------------------------------------------------------------

// Calls the fail-safe until nothing collides.
StepOutcome part_collisions(StepMethods& m, const StepInput& in, StepAttempt& a) {
  if (a.collisions.empty()) return {};
  const ResponseStep step = response_step(m, in);
  m.fail_safe->begin(step, m.detection);
  const auto ends = particle_ends(in, a);
  const std::vector<Vec3> before(ends.begin(), ends.end());
  while (!a.collisions.empty()) {
    bool resolved = false;
    a.x_tested = a.x_t1;
    a.parted.insert(a.parted.end(), a.collisions.begin(), a.collisions.end());
    {
      const auto scope = m.clock.measure("repair");
      resolved = m.fail_safe->resolve(a.collisions, a.x_t1);
      in.keep_followers(ends);
    }
    trace_stage(m, "fail-safe", a);
    if (!resolved) return {.accepted = false, .cause = m.fail_safe->failure_reason()};
    find_collisions(m, in, a);
  }
  a.fail_safe.add(exchanged_by_ends(step, before, ends));
  return {};
}

// Whether the attempt will be repeated with a shorter step, so that more rounds are in vain.
bool is_hopeless(StepMethods& m, const StepInput& in, StepAttempt& a) {
  if (!std::isfinite(in.hopeless_strain)) return false;
  const double end = m.strain.overshoot(particle_ends(in, a));
  return end > in.hopeless_strain && end > m.strain.overshoot(in.particles.x);
}

}  // namespace

// The page: each stage takes what the one before left in the attempt.
StepOutcome attempt_step(StepMethods& m, const StepInput& in, StepAttempt& a) {
  find_contacts(m, in, a);
  const bool may_cross = m.untangler && m.untangler->carries_pinches();
  if (m.pinches.add(in, a.contacts, a.x_t1, a.pinches, may_cross))
    return {.accepted = false, .cause = {}, .pinches_more = true};
  m.pinches.drop_along(in, a.pinches, a.contacts);
  m.pinches.taper(in, a.pinches, a.contacts);
  if (may_cross) m.pinches.guide(in, a.pinches, a.contacts);
  if (m.trace) m.trace->begin({in.h, in.x_t0, a.x_t1, in.inv_mass, a.contacts});
  if (m.untangling()) m.untangler->begin(in.v_coasting, in.body_step, in.h);

  StepOutcome outcome = m.traits.is_implicit ? solve_implicit(m, in, a) : solve_explicit(m, in, a);
  if (!outcome.accepted) return outcome;
  if (const std::int32_t particle = first_not_finite(in, a); particle >= 0)
    return reject_not_finite(particle, a);
  for (int round = 0;; ++round) {
    outcome = part_collisions(m, in, a);
    if (!outcome.accepted || !m.strain.bounds_strain()) return outcome;
    a.over_strain = !m.strain.is_tolerated(particle_ends(in, a));
    if (!a.over_strain || round + 1 >= kStrainRounds) return outcome;
    if (is_hopeless(m, in, a)) return outcome;
    limit_strain_beside(m, in, a);
    find_collisions(m, in, a);
  }
}

}  // namespace selvedge::detail
