// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/simulation/detail/step.h>
#include <selvedge/simulation/detail/step_ledger.h>
#include <selvedge/simulation/detail/wrench_account.h>

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

// Share of the scene's tolerance in a step near the equilibrium. With a hundredth, cloth that lies
// on a table stays at 4 to 6 thousandths of its weight out of balance.
constexpr double kSettled = 0.003;

// Strain limits and collision response disturb each other: rounds of both in one step.
constexpr int kStrainRounds = 6;

constexpr std::size_t kEndGrain = 2048;  // particles per task

std::span<Vec3> particles(const StepInput& in, std::vector<Vec3>& x_t1) {
  return std::span(x_t1).first(in.n());
}

// Held particles keep the prescribed end position, to the bit.
void move_by_velocity(const StepInput& in, std::span<const Vec3> v_mean, std::vector<Vec3>& x_t1) {
  parallel_for(in.n(), kEndGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (in.inv_mass[i] > 0.0) x_t1[i] = in.x_t0[i] + in.h * v_mean[i];
  });
  if (in.followers != nullptr) in.followers->place(particles(in, x_t1));
}

std::optional<Rejection> not_finite(const StepInput& in, std::span<const Vec3> x_t1) {
  const double count = parallel_sum(in.n(), kEndGrain, [&](std::size_t begin, std::size_t end) {
    double own = 0.0;
    for (std::size_t i = begin; i < end; ++i)
      if (!x_t1[i].allFinite()) own += 1.0;
    return own;
  });
  if (count == 0.0) return std::nullopt;
  std::size_t first = 0;
  while (x_t1[first].allFinite()) ++first;
  return Rejection{.cause = {}, .not_finite = static_cast<std::int32_t>(first)};
}

void trace_stage(const StepMethods& m, const char* stage, const StepEnds& ends,
                 const SolvedVelocities& v, std::span<const ImplicitTerm> terms = {}) {
  if (m.trace) m.trace->stage({stage, ends.x_t1, ends.collisions, terms, v.mean});
}

// -- contacts near the start ----------------------------------------------------------------------

NearContacts find_contacts(StepMethods& m, const StepInput& in, const Course& course) {
  NearContacts near{.points = {}, .pinches = course.pinches};
  m.detection.set_motion(in.x_t0, course.x_t1, in.bodies_move, StepTimes{in.t0, in.t1});
  m.detection.find_candidates();
  m.detection.find_proximities(near.points);
  const bool may_cross = m.untangler && m.untangler->carries_pinches();
  near.pinches_more = m.pinches.add(in, near.points, course.x_t1, near.pinches, may_cross);
  return near;
}

StepCounts count(const NearContacts& near) {
  StepCounts counts{.contacts = near.points.size()};
  for (const ContactPoint& c : near.points)
    counts.max_gap_violation = std::max(counts.max_gap_violation, c.rest_gap - c.gap);
  return counts;
}

// Contacts beside pinched vertices; those near the start are counted before.
void fit_to_pinches(StepMethods& m, const StepInput& in, NearContacts& near) {
  m.pinches.drop_along(in, near.pinches, near.points);
  m.pinches.taper(in, near.pinches, near.points);
  if (m.untangler && m.untangler->carries_pinches()) m.pinches.guide(in, near.pinches, near.points);
}

// -- forces ---------------------------------------------------------------------------------------

SolvedVelocities begin_forces(StepMethods& m, const StepInput& in,
                              std::span<const ContactPoint> contacts, std::vector<Vec3> v_mean) {
  const auto scope = m.clock.measure("forces");
  SolvedVelocities v{std::move(v_mean), std::vector<Vec3>(in.n(), Vec3::Zero())};
  std::vector<std::int32_t> touched;  // the particles of these contacts
  const bool everywhere =
      m.untangling() || (m.traits.follows_energy && m.sewing.goes_on(in.particles.x));
  if (!everywhere)
    for (const ContactPoint& c : contacts)
      for (const std::int32_t i : c.vertex)
        if (static_cast<std::size_t>(i) < in.n()) touched.push_back(i);
  m.integrator->begin({in.particles, in.t0, in.h, everywhere || !contacts.empty(), touched},
                      {v.mean, v.free});
  return v;
}

void begin_response(StepMethods& m, const StepInput& in, std::span<const ContactPoint> contacts,
                    std::span<const Vec3> v_mean) {
  const auto scope = m.clock.measure("response");
  ResponseStep step = response_step(m, in);
  if (!contacts.empty()) step.unbalanced = m.integrator->unbalanced(v_mean);
  m.response->begin(step);
  m.response->add(contacts);
}

std::span<const ImplicitTerm> response_terms(StepMethods& m) {
  const auto scope = m.clock.measure("response");
  return m.response->terms();
}

bool update_response(StepMethods& m, std::span<Vec3> v_mean) {
  const auto scope = m.clock.measure("response");
  return m.response->update(v_mean);
}

// One solve with these terms of the response.
SolveReport solve(StepMethods& m, const StepInput& in, std::span<const ImplicitTerm> terms,
                  double looser, SolvedVelocities& v) {
  const auto scope = m.clock.measure("solve");
  v.answered = !terms.empty();
  if (m.untangling()) terms = m.untangler->with_drive(terms, in.particles.mass);
  return m.integrator->solve(m.stops.with(terms), {v.mean, v.free},
                             (in.settles ? kSettled : 1.0) * (v.answered ? looser : 1.0));
}

StepCounts count(const SolveReport& report) {
  return {.solves = 1,
          .solver_iterations = report.iterations,
          .solves_not_converged = report.converged ? 0 : 1,
          .solver_bytes = report.bytes};
}

// -- answers on the end positions -----------------------------------------------------------------

bool keep(const StepInput& in, std::span<Vec3> ends) {
  in.keep_followers(ends);
  return in.followers != nullptr;
}

// Notes what the stage `name` gives to the free particles while this object lives.
class StageNote {
 public:
  StageNote(const StepMethods& m, const StepInput& in, const char* name, StepEnds& ends)
      : in_(in), name_(name), ends_(ends) {
    if (m.notes_stages) before_.assign(ends.x_t1.begin(), ends.x_t1.begin() + count());
  }
  StageNote(const StageNote&) = delete;
  StageNote& operator=(const StageNote&) = delete;
  ~StageNote() {
    if (!before_.empty()) ends_.given[name_] += given(in_, before_, ends_.x_t1, in_.h);
  }

 private:
  std::ptrdiff_t count() const { return static_cast<std::ptrdiff_t>(in_.n()); }

  const StepInput& in_;
  const char* name_;
  StepEnds& ends_;
  std::vector<Vec3> before_;  // empty: not asked for
};

// The ends that the velocities and the response give. The bodies and held particles of `x_t1` are
// at their ends.
StepEnds correct_ends(StepMethods& m, const StepInput& in, const SolvedVelocities& v,
                      std::vector<Vec3> x_t1) {
  StepEnds ends{.x_t1 = std::move(x_t1)};
  move_by_velocity(in, v.mean, ends.x_t1);
  m.strain.begin();
  const auto own = particles(in, ends.x_t1);
  if (!m.traits.ends_with_mean) ends.x_free.assign(own.begin(), own.end());
  const auto scope = m.clock.measure("response");
  const StageNote note(m, in, "response", ends);
  m.response->correct(ends.x_t1);
  in.keep_followers(own);
  return ends;
}

StepCounts limit_strain(StepMethods& m, const StepInput& in, StepEnds& ends) {
  if (!m.strain.acts()) return {};
  const StageNote note(m, in, "strain_limit", ends);
  return {.strain_sweeps = m.strain.limit(
              limit_step(in), particles(in, ends.x_t1),
              [&](std::span<Vec3> own) { return keep(in, own); }, m.clock)};
}

StepCounts limit_strain_beside(StepMethods& m, const StepInput& in,
                               std::span<const ContactPoint> parted, StepEnds& ends) {
  const StageNote note(m, in, "strain_limit", ends);
  return {.strain_sweeps = m.strain.limit_beside(
              limit_step(in), {parted, in.inv_mass}, ends.x_t1,
              [&](std::span<Vec3> own) { return keep(in, own); }, m.clock)};
}

StepCounts collide(StepMethods& m, const StepInput& in, StepEnds& ends) {
  const StepCounts counts{.candidate_rebuilds = m.detection.renew_candidates() ? 1 : 0};
  m.detection.find_collisions(ends.collisions);
  if constexpr (kValidatesSteps)
    validate_attempt(m.validator, m.detection.searched(), m.names, in.step);
  return counts;
}

// Contacts, limits and a test of the paths that result.
void finish_ends(StepMethods& m, const StepInput& in, Solution& s) {
  s.ends = correct_ends(m, in, s.v, std::move(s.ends.x_t1));
  trace_stage(m, "contacts", s.ends, s.v);
  if ((s.rejection = not_finite(in, s.ends.x_t1))) return;
  s.ends.response =
      exchanged_by_response(ledger_step(m, in), *m.response, s.v, particles(in, s.ends.x_t1));
  s.counts += limit_strain(m, in, s.ends);
  if (m.strain.acts()) trace_stage(m, "strain limit", s.ends, s.v);
  s.counts += collide(m, in, s.ends);
}

void add_collisions_as_contacts(StepMethods& m, Solution& s) {
  m.response->add(s.ends.collisions);
  s.met.insert(s.met.end(), s.ends.collisions.begin(), s.ends.collisions.end());
}

// -- forces with contacts -------------------------------------------------------------------------

// Forces, contacts and friction give the end-of-step state. Collisions on the way to it become
// contacts of another solve.
Solution solve_implicit(StepMethods& m, const StepInput& in, std::span<const ContactPoint> contacts,
                        Course course) {
  Solution s{.v = begin_forces(m, in, contacts, std::move(course.v_mean)),
             .ends = {.x_t1 = std::move(course.x_t1)}};
  begin_response(m, in, contacts, s.v.mean);
  m.stops.begin(in.particles.x, s.v.mean, in.h);
  bool again = true;  // a solve although the response has no terms
  int collision_solves = 0;
  double looser = kLoosest;
  for (int round = 0; round < kMaxSolves + kMaxCollisionSolves; ++round) {
    double residual = 0.0;
    // A response without terms does all of its work after the solve, so that one solve suffices.
    if (const auto terms = response_terms(m); again || s.v.answered || !terms.empty()) {
      const SolveReport report = solve(m, in, terms, looser, s.v);
      s.counts += count(report);
      residual = report.residual;
      if (m.trace) move_by_velocity(in, s.v.mean, s.ends.x_t1);
      trace_stage(m, collision_solves == 0 ? "solve" : "collision solve", s.ends, s.v, terms);
    }
    const bool changed = update_response(m, s.v.mean);
    again = m.stops.update(s.v.mean);
    if ((changed || again) && round + 1 < kMaxSolves) {
      if (looser > 1.0) looser = std::max(kLooser, kTightening * looser);
      continue;
    }
    if (std::exchange(looser, 1.0) > 1.0 && residual > m.scene.solver.tolerance) continue;
    finish_ends(m, in, s);
    if (s.rejection || s.ends.collisions.empty() || ++collision_solves > kMaxCollisionSolves)
      return s;
    add_collisions_as_contacts(m, s);
  }
  return s;
}

// The velocity at the end changes with the mean velocity of the step.
void drive_untangling(StepMethods& m, const StepInput& in, SolvedVelocities& v) {
  const std::vector<Vec3> before = v.mean;
  m.untangler->set_velocities(in.inv_mass, v.mean);
  for (std::size_t i = 0; i < in.n(); ++i) v.free[i] += v.mean[i] - before[i];
}

// The integrator computes the end; collisions on the way become contacts of another correction.
Solution solve_explicit(StepMethods& m, const StepInput& in, std::span<const ContactPoint> contacts,
                        Course course) {
  Solution s{.v = begin_forces(m, in, contacts, std::move(course.v_mean)),
             .ends = {.x_t1 = std::move(course.x_t1)}};
  if (m.untangling()) drive_untangling(m, in, s.v);
  if (m.trace) move_by_velocity(in, s.v.mean, s.ends.x_t1);
  trace_stage(m, "explicit step", s.ends, s.v);
  begin_response(m, in, contacts, s.v.mean);
  for (int round = 0;; ++round) {
    if (const double stable = m.response->stable_step(); !(in.h <= stable)) {
      s.ends.collisions.clear();
      s.rejection = Rejection{.cause = "the contacts of " + m.scene.contact.response +
                                       " bear explicit steps below " + std::to_string(stable) +
                                       " s, this one has " + std::to_string(in.h) + " s"};
      return s;
    }
    finish_ends(m, in, s);
    if (s.rejection || s.ends.collisions.empty() || round >= kMaxCollisionSolves) return s;
    add_collisions_as_contacts(m, s);
  }
}

// -- collisions -----------------------------------------------------------------------------------

// Calls the fail-safe until nothing collides.
void part_collisions(StepMethods& m, const StepInput& in, const SolvedVelocities& v,
                     std::vector<ContactPoint>& parted, Parting& p) {
  StepEnds& ends = p.ends;
  if (ends.collisions.empty()) return;
  const ResponseStep step = response_step(m, in);
  m.fail_safe->begin(step, m.detection);
  const auto own = particles(in, ends.x_t1);
  const std::vector<Vec3> before(own.begin(), own.end());
  while (!ends.collisions.empty()) {
    bool resolved = false;
    p.x_tested = ends.x_t1;
    parted.insert(parted.end(), ends.collisions.begin(), ends.collisions.end());
    {
      const auto scope = m.clock.measure("repair");
      const StageNote note(m, in, "fail_safe", ends);
      resolved = m.fail_safe->resolve(ends.collisions, ends.x_t1);
      in.keep_followers(own);
    }
    trace_stage(m, "fail-safe", ends, v);
    if (!resolved) {
      p.rejection = Rejection{.cause = m.fail_safe->failure_reason()};
      return;
    }
    p.counts += collide(m, in, ends);
  }
  p.fail_safe.add(exchanged_by_ends(ledger_step(m, in), before, own));
}

// Whether the attempt will be repeated with a shorter step, so that more rounds are in vain.
bool is_hopeless(StepMethods& m, const StepInput& in, std::span<const Vec3> ends) {
  if (!std::isfinite(in.hopeless_strain)) return false;
  const double end = m.strain.overshoot(ends);
  return end > in.hopeless_strain && end > m.strain.overshoot(in.particles.x);
}

// Collisions and strain limits disturb each other, so they take turns.
Parting part(StepMethods& m, const StepInput& in, const SolvedVelocities& v, StepEnds ends) {
  Parting p{.ends = std::move(ends)};
  if ((p.rejection = not_finite(in, p.ends.x_t1))) {
    p.ends.collisions.clear();
    return p;
  }
  std::vector<ContactPoint> parted;
  for (int round = 0;; ++round) {
    part_collisions(m, in, v, parted, p);
    if (p.rejection || !m.strain.bounds_strain()) return p;
    const auto own = particles(in, p.ends.x_t1);
    p.over_strain = !m.strain.is_tolerated(own);
    if (!p.over_strain || round + 1 >= kStrainRounds || is_hopeless(m, in, own)) return p;
    p.counts += limit_strain_beside(m, in, parted, p.ends);
    trace_stage(m, "strain limit", p.ends, v);
    p.counts += collide(m, in, p.ends);
  }
}

Parting rejected(Solution& s) {
  return {.ends = std::move(s.ends), .rejection = std::move(s.rejection)};
}

}  // namespace

// The page: each stage takes what the one before gave.
StepOutcome attempt_step(StepMethods& m, const StepInput& in, Course course) {
  NearContacts near = find_contacts(m, in, course);
  StepCounts counts = count(near);
  if (near.pinches_more) return {.near = std::move(near), .counts = counts};
  fit_to_pinches(m, in, near);
  if (m.trace) m.trace->begin({in.h, in.x_t0, course.x_t1, in.inv_mass, near.points});
  if (m.untangling()) m.untangler->begin(in.v_coasting, in.body_step, in.h);

  Solution s = m.traits.is_implicit ? solve_implicit(m, in, near.points, std::move(course))
                                    : solve_explicit(m, in, near.points, std::move(course));
  Parting p = s.rejection ? rejected(s) : part(m, in, s.v, std::move(s.ends));
  counts += s.counts;
  counts += p.counts;
  return {.near = std::move(near),
          .v = std::move(s.v),
          .met = std::move(s.met),
          .parting = std::move(p),
          .counts = counts};
}

}  // namespace selvedge::detail
