// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/integrator.h>
#include <selvedge/core/strain_limiter.h>
#include <selvedge/scene/detail/energy_balance.h>
#include <selvedge/scene/detail/step_ledger.h>
#include <selvedge/scene/detail/strain_stage.h>
#include <selvedge/scene/detail/water.h>
#include <selvedge/scene/detection.h>
#include <selvedge/scene/phase_clock.h>
#include <selvedge/scene/simulation.h>
#include <selvedge/scene/strain_reach.h>
#include <selvedge/scene/untangle.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace selvedge {

/// What a simulation is made of. simulation.cpp has its life, simulation_start.cpp how it begins
/// and simulation_step.cpp one try of a step.
struct Simulation::Parts {
  Scene scene;
  BuiltScene built;
  std::vector<Triangle> body_triangles;
  PhaseClock clock;
  Detection detection;
  StrainLimiter strain;  // measures
  StrainReach reach;     // proves that it need not
  detail::StrainStage strain_stage;
  std::unique_ptr<Integrator> integrator;
  IntegratorTraits method;  // of the integrator
  std::unique_ptr<Response> response;
  std::unique_ptr<FailSafe> fail_safe;

  SimulationState state;
  Particles particles;               // the same x and v, with masses
  std::vector<double> mass;          // of particles
  std::vector<double> inv_mass;      // of particles and body vertices (0)
  std::vector<Vec3> x_t0, x_t1;      // particles, then body vertices
  std::vector<Vec3> body_step;       // x_t1 - x_t0 of the body vertices
  std::vector<Vec3> body_x;          // of the body vertices at the state's time
  std::vector<Vec3> v_t1;            // mean velocities of the step
  std::vector<Vec3> x_free, v_free;  // ends without contacts and limits, unless v_t1 is the end
  std::vector<Vec3> predicted, v_before_untangling;
  std::vector<ContactPoint> contacts, hits;
  bool answered_in_solve = false;  // the last solve had terms of the response
  detail::StepLedger ledger;
  detail::EnergyBalance balance;
  std::vector<Vec3> v_end;  // velocities of a try that is weighed
  std::vector<ContactImpulse> impulses;
  RunResult result;
  std::string trouble;         // why the last try failed
  std::vector<Vec3> unparted;  // x_t1 that the fail-safe was given last
  std::vector<double> tried;   // s, of the last step
  FailedTry failed;
  VertexNames names;
  std::optional<Untangler> untangler;
  std::optional<detail::Water> water;
  const StepTrace* trace = nullptr;

  Parts(const Scene& s, BuiltScene b, const Methods& methods);

  std::size_t n() const { return state.x.size(); }

  void place_bodies(double time, std::vector<Vec3>& x) const;
  void note_bodies(const std::vector<Vec3>& x) {
    body_x.assign(x.begin() + static_cast<std::ptrdiff_t>(n()), x.end());
  }

  bool bodies_move(double t0, double t1) const {
    return std::any_of(built.bodies.begin(), built.bodies.end(),
                       [&](const auto& body) { return !body->is_static(t0, t1); });
  }

  void look_at_state();
  Crossings crossings_now();
  void refuse_crossing_start();
  bool untangling() const { return untangler && untangler->active(); }
  void start_untangling();
  void go_on_untangling();
  void resume_untangling();

  void note_strain();
  std::map<std::string, PlanFigures> plan_figures() const;
  std::vector<std::uint8_t> flags() const;
  void verify_frame();
  // How much of its rest gap a contact lacks at the start of a step, so of all states but the last.
  void note_lacks() {
    double& largest = result.counters["max_gap_lack_m"];
    for (const ContactPoint& c : contacts) largest = std::max(largest, c.rest_gap - c.gap);
  }

  // Sets masses for the step and the prescribed end positions of held particles.
  void hold_particles(double t0, double t1, double h);
  ResponseStep response_step(double h) const {
    return {{x_t0, inv_mass, n(), h}, mass, body_step, state.v, predicted, method.is_implicit};
  }
  void set_end_from_velocity(double h);
  bool is_finite();
  void solve_implicit(double h);
  bool step_explicit(double h);
  bool bears_contacts(double h);
  void answer_contacts(double h);
  bool limits_hold();
  bool strain_is_tolerated();
  void limit_strain(double h);
  bool find_hits();
  bool resolve_collisions(double h);
  bool try_step(double h, double t1);
  double nominal_step() const { return 1.0 / (scene.time.fps * scene.time.steps_per_frame); }
  StepControl control() const;
  double stable_step(double h, double target);
  double longest_step(double h);
  void refuse_unstable_start();
  LimitStep limit_step(double h) const;
  void set_velocities(double h, std::span<Vec3> v) const;
  bool gains_energy(double h);
  void untangle_velocities();
  void note_memory();
  void make_step(StepControl control);
  void note_failure(double h);
  [[noreturn]] void give_up();
  void tell(const char* stage, std::span<const ImplicitTerm> terms = {}) const {
    if (trace) trace->stage({stage, x_t1, hits, terms, v_t1});
  }
  void accept(double h, double t1);
};

}  // namespace selvedge
