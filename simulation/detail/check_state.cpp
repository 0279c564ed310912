// SPDX-License-Identifier: MIT
//
// Checks of accepted states: crossings, tangles, strain, flags; and the result so far.
#include <selvedge/simulation/detail/simulation_parts.h>
#include <selvedge/simulation/detail/vertex_flags.h>

#include <algorithm>
#include <cmath>

namespace selvedge {
namespace {

double max_norm(std::span<const Vec3> v) {
  double largest = 0.0;
  for (const Vec3& u : v) largest = std::max(largest, u.squaredNorm());
  return std::sqrt(largest);
}

}  // namespace

// The detection sees the state as a motion that stands still.
void Simulation::Parts::look_at_state() {
  std::copy(state.x.begin(), state.x.end(), input.x_t0.begin());
  detail::place_bodies(built, state.time, input.x_t0);
  methods.detection.set_motion(input.x_t0, input.x_t0,
                               detail::bodies_move(built, state.time, state.time),
                               detail::StepTimes{state.time, state.time});
}

detail::Crossings Simulation::Parts::crossings_now() {
  look_at_state();
  const auto scope = clock.measure("verify");
  detail::Crossings found = methods.detection.find_crossings();
  uncrossed = scene.plan.proofs && found.empty();
  return found;
}

// Whether an accepted step proves that its end has no crossing if its start has none. Proof: take
// the first time at which an edge meets a triangle without a common vertex. If neither an end of
// the edge lies on the triangle nor the edge meets an edge of the triangle, then the edge passes
// through the inside, as it did just before: not the first time. So a point and a triangle or two
// edges meet then, and a step is accepted only if a search that misses no pair and no collision
// finds none. Needs the search of the cloth with itself, and no pair may be excluded.
bool Simulation::Parts::steps_prove_uncrossed() const {
  const detail::SearchedMotion motion = methods.detection.searched();
  const bool excludes = motion.excluded_surfaces != nullptr ||
                        (motion.excluded != nullptr && !motion.excluded->empty());
  return motion.self && motion.finds_all_collisions && !excludes && !methods.untangling();
}

// Whether the step or the look at the state starts with the bodies at body_x: a program may have
// moved them since.
bool Simulation::Parts::bodies_are_in_place() const {
  return std::ranges::equal(std::span(input.x_t0).subspan(n()), body_x);
}

// The accepted step carries the proof from its start to its end, if it starts at the very state
// that is proved, bodies included.
void Simulation::Parts::carry_proof() {
  const auto scope = clock.measure("verify");
  uncrossed = uncrossed && bodies_are_in_place() && steps_prove_uncrossed();
}

// Whether the steps have proved the state of look_at_state. The last frame of a scene is searched
// all the same, and so is every frame in validation builds.
bool Simulation::Parts::is_proved_uncrossed() const {
  const std::int64_t steps = std::int64_t{scene.time.frames} * scene.time.steps_per_frame;
  return !detail::kValidatesSteps && control().done < steps && uncrossed && bodies_are_in_place();
}

void Simulation::Parts::verify_frame() {
  count_flags(flags(), result.flags);
  if (methods.untangling()) return;  // the untangler has just counted the crossings
  look_at_state();
  if (is_proved_uncrossed()) {
    methods.detection.note_uncrossed();
    return;
  }
  const detail::Crossings found = crossings_now();
  const auto note_worst = [](int& worst, const TriangleMeetings& pairs) {
    worst = std::max(worst, static_cast<int>(pairs.crossings.size() + pairs.touches.size()));
  };
  note_worst(result.worst_self_intersections, found.self);
  note_worst(result.worst_body_intersections, found.body);
  result.clean = result.clean && found.empty();
}

bool Simulation::Parts::verifies_clean() {
  verify_frame();
  return present_result().clean;
}

void Simulation::Parts::note_bodies(std::span<const Vec3> x) {
  const auto bodies = x.subspan(n());
  body_x.assign(bodies.begin(), bodies.end());
}

void Simulation::Parts::note_memory() {
  state.memory.clear();
  methods.integrator->save_memory(state.memory);
  state.contact_memory.clear();
  methods.response->save_memory(state.contact_memory);
}

void Simulation::Parts::note_strain() {
  const auto now = methods.strain.measure(state.x, result.max_stretch, clock);
  if (!now) return;
  result.max_stretch = std::max(result.max_stretch, now->max_strain);
  result.strain_residual =
      std::max(result.strain_residual, std::max(0.0, now->residual - detail::kStrainTolerance));
}

std::vector<std::uint8_t> Simulation::Parts::flags() const {
  return detail::vertex_flags(
      {built.cloth, state.x, outcome.near.points, state.pinches, state.tangles.list,
       methods.untangler && methods.untangler->report().given_up, detail::kStrainTolerance});
}

std::string Simulation::Parts::enclosed_sentence(const detail::Enclosed& found,
                                                 const char* when) const {
  return methods.names.vertex(found.vertex) +
         " and all the cloth that is connected to it lie inside a " + "closed body, " +
         methods.names.owner(found.body_vertex) + ", " + when;
}

void Simulation::Parts::continue_untangling() {
  detail::Untangler& untangler = *methods.untangler;
  untangler.finish(state.v);
  look_at_state();
  const auto scope = clock.measure("untangle");
  untangler.update(input.x_t0, methods.detection.find_edge_crossings(), state.time);
  state.tangles = untangler.tangles();
  // Cloth with no vertex outside a closed body may have been untangled into it.
  if (!untangler.active())
    if (const auto found =
            detail::find_enclosed(methods.detection.joint_surface(), input.x_t0, {})) {
      result.clean = false;
      throw SimulationFailed(
          FailureKind::not_clean,
          enclosed_sentence(*found, "after it was untangled") + "; start with more of it outside");
    }
  if (!untangler.report().given_up || scene.contact.carry_tangled) return;
  throw SimulationFailed(FailureKind::not_clean,
                         "no way was found to untangle the cloth: " + crossings_now().sentence() +
                             "; start with the pieces apart there, or set contact.still_tangled "
                             "to \"carry\"");
}

RunResult Simulation::Parts::present_result() const {
  RunResult r = result;
  for (const auto& [name, value] : methods.fail_safe->counters()) r.counters[name] = value;
  for (const auto& [name, value] : methods.integrator->counters()) r.counters[name] = value;
  if (const double count = static_cast<double>(methods.detection.substituted_self_searches());
      count > 0.0)
    r.counters["substituted_" + scene.contact.broad_phase + "_by_bvh_aabb"] = count;
  r.ledger = ledger.figures();
  r.ledger["balance"] = balance.figures();
  if (methods.strain.acts()) r.ledger["strain_limiter"] = methods.strain.figures();
  for (const auto& [part, count] : methods.detection.counts())
    r.plan[part] = {count.asked, count.idle, count.saved_s()};
  if (const detail::IdleCount& count = methods.strain.idle_count(); count.asked > 0)
    r.plan["strain_limit"] = {count.asked, count.idle, count.saved_s()};
  if (water) r.counters["dripped_kg"] = water->dripped();
  r.phase_s = clock.seconds();
  if (methods.untangler) {
    r.tangle = methods.untangler->report();
    r.clean = r.clean && r.tangle.elsewhere == 0;
  }
  r.clean = r.clean && !attempts.given_up;
  r.clean_elsewhere = r.clean;
  r.clean = r.clean && !methods.untangling() && r.tangle.jams == 0;
  r.final_max_speed = max_norm(state.v);
  r.state_hash = selvedge::state_hash(state);
  carry_on(before, r);
  r.steps = static_cast<int>(state.step);
  return r;
}

// The sums (ledger, dripped water) go on, so that their last bits do not depend on where the parts
// of a run meet.
void Simulation::Parts::continue_from(RunResult earlier) {
  before = std::move(earlier);
  ledger.continue_from(before.ledger);
  balance.continue_from(before.ledger["balance"]);
  methods.strain.continue_from(before.ledger["strain_limiter"]);
  before.ledger.clear();
  if (const auto dripped = before.counters.extract("dripped_kg"); water && dripped)
    water->continue_from(dripped.mapped());
}

}  // namespace selvedge
