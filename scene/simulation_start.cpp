// SPDX-License-Identifier: MIT
//
// How a simulation begins, and how its states are looked at: crossings, tangles, strain.
#include <selvedge/scene/detail/handles.h>
#include <selvedge/scene/detail/scene_forces.h>
#include <selvedge/scene/detail/simulation_parts.h>
#include <selvedge/scene/vertex_flags.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace selvedge {
namespace {

std::unique_ptr<Integrator> make_integrator(const Scene& scene, const BuiltScene& built,
                                            const Methods& methods) {
  IntegratorConfig config;
  config.solve = {scene.solver.tolerance, scene.solver.max_iterations};
  config.error = scene.solver.error;
  config.drag = scene.solver.drag;
  config.max_newton = scene.solver.max_newton;
  const auto found = methods.integrators.find(scene.solver.integrator);
  if (found == methods.integrators.end())
    throw std::invalid_argument("solver.integrator: there is no \"" + scene.solver.integrator +
                                "\"; `selvedge list` names them");
  return found->second(detail::make_forces(scene, built), built.cloth.surface.vertices.size(),
                       config);
}

void note_critical_step(const Scene& scene, const BuiltScene& built, double h, RunResult& result) {
  const std::size_t n = built.cloth.surface.vertices.size();
  ForceSum forces(detail::make_forces(scene, built), n);
  Particles particles{built.cloth.surface.vertices, built.velocity, built.cloth.mass, {}};
  for (const double m : particles.mass) particles.inv_mass.push_back(1.0 / m);
  const CriticalStep step = critical_step(forces, particles, h);
  result.counters["max_critical_step_s"] = step.longest_step;
  result.counters["max_critical_stiffness_factor"] = step.stiffening;
  result.counters["max_provot_stiffness_N_per_m"] = step.provot_stiffness;
}

}  // namespace

Simulation::Parts::Parts(const Scene& s, BuiltScene b, const Methods& methods)
    : scene(s),
      built(detail::with_policy(scene, std::move(b))),
      detection(scene, built, methods, clock),
      strain(built.cloth.springs, detail::limiter_targets(built.cloth.strain_limit),
             built.cloth.surface.vertices.size()),
      reach(scene.plan.proofs, strain),
      strain_stage(scene, built, methods.strain_limiters),
      integrator(make_integrator(scene, built, methods)),
      method(integrator->traits()),
      response(make_method(methods.responses, scene.contact.response, "contact.response",
                           scene.contact.response_config)),
      fail_safe(make_method(methods.fail_safes, scene.contact.fail_safe, "contact.fail_safe")),
      balance(scene, built, response->traits()),
      names(scene, built) {
  detail::refuse_bad_handles(scene, built);
  detail::refuse_unfit_response(scene, *response, built.cloth.mass, nominal_step(),
                                !method.is_implicit);
  const std::size_t n = built.cloth.surface.vertices.size();
  state.x = built.cloth.surface.vertices;
  state.v = built.velocity;
  note_memory();
  mass = built.cloth.mass;
  particles.mass = mass;
  particles.inv_mass.assign(n, 0.0);
  v_free.resize(n);
  x_free.resize(n);
  body_triangles.assign(detection.body_triangles().begin(), detection.body_triangles().end());
  const std::size_t m = detection.body_vertices();
  inv_mass.assign(n + m, 0.0);
  x_t0.resize(n + m);
  x_t1.resize(n + m);
  body_step.resize(m);
  if (scene.water) water.emplace(scene, built);
  place_bodies(state.time, x_t0);
  note_bodies(x_t0);
  refuse_crossing_start();
  refuse_unstable_start();
  if (scene.solver.strain_limiter && scene.solver.limiter == "critical_step")
    note_critical_step(scene, built, nominal_step(), result);
  note_strain();
}

void Simulation::Parts::place_bodies(double time, std::vector<Vec3>& x) const {
  for (std::size_t b = 0; b < built.bodies.size(); ++b)
    built.bodies[b]->positions(time, std::span(x).subspan(n() + detection.body_begin()[b],
                                                          built.bodies[b]->vertex_count()));
}

void Simulation::Parts::look_at_state() {
  std::copy(state.x.begin(), state.x.end(), x_t0.begin());
  place_bodies(state.time, x_t0);
  detection.set_motion(x_t0, x_t0, bodies_move(state.time, state.time),
                       StepTimes{state.time, state.time});
}

Crossings Simulation::Parts::crossings_now() {
  look_at_state();
  const auto scope = clock.measure("verify");
  return detection.find_crossings();
}

void Simulation::Parts::refuse_crossing_start() {
  const Crossings found = crossings_now();
  if (scene.contact.untangle_start) return start_untangling();
  refuse_crossings(found, scene.contact.self);
}

// What is proved to be no larger than what was noted before needs no look.
void Simulation::Parts::note_strain() {
  {
    const auto scope = clock.measure("plan");
    if (reach.keeps_below(state.x, result.max_stretch, detail::strain_tolerance)) return;
  }
  const StrainReport now = reach.measure(strain, state.x);
  result.max_stretch = std::max(result.max_stretch, now.max_strain);
  result.strain_residual =
      std::max(result.strain_residual, std::max(0.0, now.residual - detail::strain_tolerance));
}

std::vector<std::uint8_t> Simulation::Parts::flags() const {
  return vertex_flags({built.cloth, state.x, contacts, state.tangles.list,
                       untangler && untangler->report().given_up, detail::strain_tolerance});
}

std::map<std::string, PlanFigures> Simulation::Parts::plan_figures() const {
  std::map<std::string, PlanFigures> figures = detection.plan_figures();
  const IdleCount& count = reach.count();
  if (count.asked > 0) figures["strain_limit"] = {count.asked, count.idle, count.saved_s()};
  return figures;
}

void Simulation::Parts::verify_frame() {
  count_flags(flags(), result.flags);
  if (untangling()) return;  // has just been looked at, and the result counts it
  const Crossings found = crossings_now();
  result.worst_self_intersections =
      std::max(result.worst_self_intersections, static_cast<int>(found.self.size()));
  result.worst_body_intersections =
      std::max(result.worst_body_intersections, static_cast<int>(found.body.size()));
  result.clean = result.clean && found.self.empty() && found.body.empty();
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

}  // namespace selvedge
