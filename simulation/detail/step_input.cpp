// SPDX-License-Identifier: MIT
//
// The ends of a step's data: from the state to its input and course, and from its outcome to
// velocities.
#include <selvedge/core/base/parallel.h>
#include <selvedge/simulation/detail/handles.h>
#include <selvedge/simulation/detail/step.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

// Particles per task.
constexpr std::size_t kInputGrain = 2048;

// A follower is held if all its leaders are.
void hold_followers(StepInput& in, std::span<Vec3> x_t1) {
  const Followers& f = *in.followers;
  for (const std::int32_t i : f.nodes())
    if (std::ranges::all_of(f.shares(i), [&](const Followers::Share& s) {
          return in.particles.inv_mass[f.leaders()[s.leader]] <= 0.0;
        }))
      in.particles.inv_mass[i] = 0.0;
  f.place(in.v_coasting);
  f.place(x_t1.first(in.n()));
}

}  // namespace

bool bodies_move(const BuiltScene& built, double t0, double t1) {
  return std::any_of(built.bodies.begin(), built.bodies.end(),
                     [&](const auto& body) { return !body->is_static(t0, t1); });
}

void place_bodies(const BuiltScene& built, double time, std::span<Vec3> x) {
  std::size_t first = built.cloth.surface.vertices.size();
  for (const auto& body : built.bodies) {
    body->positions(time, x.subspan(first, body->vertex_count()));
    first += body->vertex_count();
  }
}

void hold_particles(const Scene& scene, const BuiltScene& built, const SimulationState& state,
                    StepInput& in, std::span<Vec3> x_t1) {
  Particles& particles = in.particles;
  for (std::size_t i = 0; i < in.n(); ++i) particles.inv_mass[i] = 1.0 / particles.mass[i];
  in.v_coasting = state.v;
  visit_held(scene, built, in.t0, in.t1, [&](std::int32_t i, const Vec3& end, std::int32_t) {
    particles.inv_mass[i] = 0.0;
    in.v_coasting[i] = (end - state.x[i]) / in.h;
    x_t1[i] = end;
  });
  for (const HeldByProgram& held : in.program->held) {
    const std::int32_t i = held.particle;
    particles.inv_mass[i] = 0.0;
    x_t1[i] = held.at(in.t1);
    in.v_coasting[i] = (x_t1[i] - state.x[i]) / in.h;
  }
  if (in.followers != nullptr) hold_followers(in, x_t1);
  if (in.followers != nullptr && in.followers->has_rigid()) {
    in.contact_mass = particles.mass;
    in.followers->set_inertia(particles.mass, in.contact_mass);
    in.followers->set_mobility(particles.mass, particles.inv_mass);
  }
  std::copy(particles.inv_mass.begin(), particles.inv_mass.end(), in.inv_mass.begin());
}

Course begin_step(const Scene& scene, const BuiltScene& built, const SimulationState& state,
                  StepInput& in) {
  Course course{.x_t1 = std::vector<Vec3>(in.x_t0.size()), .v_mean = std::vector<Vec3>(in.n())};
  std::vector<Vec3>& x_t1 = course.x_t1;
  in.step = state.step;
  in.particles.x = state.x;
  in.particles.v = state.v;
  in.bodies_move = bodies_move(built, in.t0, in.t1);
  std::copy(state.x.begin(), state.x.end(), in.x_t0.begin());
  place_bodies(built, in.t0, in.x_t0);
  place_bodies(built, in.t1, x_t1);
  for (std::size_t j = 0; j < in.body_step.size(); ++j)
    in.body_step[j] = x_t1[in.n() + j] - in.x_t0[in.n() + j];
  hold_particles(scene, built, state, in, x_t1);
  parallel_for(in.n(), kInputGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (in.inv_mass[i] > 0.0) in.v_coasting[i] += in.h * scene.gravity;
  });
  const std::vector<Vec3>& force = in.program->force;
  for (std::size_t i = 0; i < force.size(); ++i)
    if (in.inv_mass[i] > 0.0) in.v_coasting[i] += in.h / in.particles.mass[i] * force[i];
  if (in.followers != nullptr) in.followers->place(in.v_coasting);
  parallel_for(in.n(), kInputGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      course.v_mean[i] = in.v_coasting[i];
      if (in.inv_mass[i] > 0.0) x_t1[i] = in.x_t0[i] + in.h * course.v_mean[i];
    }
  });
  if (in.followers != nullptr) in.followers->place(std::span(x_t1).first(in.n()));
  return course;
}

void end_velocities(const IntegratorTraits& traits, const StepInput& in, const StepOutcome& outcome,
                    std::span<Vec3> v) {
  const StepEnds& ends = outcome.parting.ends;
  parallel_for(in.n(), kInputGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const bool mean = traits.ends_with_mean || !(in.inv_mass[i] > 0.0);
      v[i] = mean ? Vec3((ends.x_t1[i] - in.x_t0[i]) / in.h)
                  : Vec3(outcome.v.free[i] + (ends.x_t1[i] - ends.x_free[i]) / in.h);
    }
  });
}

ResponseStep response_step(const StepMethods& m, const StepInput& in) {
  return {{in.x_t0, in.inv_mass, in.n(), in.h, in.followers},
          in.contact_mass.empty() ? in.particles.mass : in.contact_mass,
          in.body_step,
          in.particles.v,
          in.v_coasting,
          m.traits.is_implicit,
          {},
          std::min(in.h, in.nominal_h),
          in.settles};
}

ResponseStep ledger_step(const StepMethods& m, const StepInput& in) {
  ResponseStep step = response_step(m, in);
  step.mass = in.particles.mass;
  return step;
}

LimitStep limit_step(const StepInput& in) {
  return {std::span(in.x_t0).first(in.n()), std::span(in.inv_mass).first(in.n()), in.h};
}

StepCounts& StepCounts::operator+=(const StepCounts& other) {
  contacts += other.contacts;
  candidate_rebuilds += other.candidate_rebuilds;
  solves += other.solves;
  solver_iterations += other.solver_iterations;
  solves_not_converged += other.solves_not_converged;
  solver_bytes += other.solver_bytes;
  if (other.strain_sweeps >= 0) strain_sweeps = std::max(strain_sweeps, 0) + other.strain_sweeps;
  max_gap_violation = std::max(max_gap_violation, other.max_gap_violation);
  return *this;
}

void StepCounts::add_to(std::map<std::string, double>& counters) const {
  counters["contacts"] += static_cast<double>(contacts);
  double& violation = counters["max_gap_violation_m"];
  violation = std::max(violation, max_gap_violation);
  if (candidate_rebuilds > 0) counters["candidate_rebuilds"] += candidate_rebuilds;
  if (solves > 0) {
    counters["solves"] += solves;
    counters["solver_iterations"] += solver_iterations;
    counters["solver_bytes"] += static_cast<double>(solver_bytes);
    counters["solves_not_converged"] += solves_not_converged;
  }
  if (strain_sweeps >= 0) counters["strain_sweeps"] += strain_sweeps;
}

}  // namespace selvedge::detail
