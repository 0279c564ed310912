// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/parallel.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/contacts/detail/phase_clock.h>
#include <selvedge/simulation/detail/enclosed.h>
#include <selvedge/simulation/detail/energy_balance.h>
#include <selvedge/simulation/detail/joined_steps.h>
#include <selvedge/simulation/detail/sleep.h>
#include <selvedge/simulation/detail/step.h>
#include <selvedge/simulation/detail/step_ledger.h>
#include <selvedge/simulation/detail/strain_guard.h>
#include <selvedge/simulation/detail/turning_bodies.h>
#include <selvedge/simulation/detail/water.h>
#include <selvedge/simulation/detail/wrench_account.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/simulation/step_report.h>

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// See CarriedSimulation.
struct Simulation::Carried {
  SimulationState state;
  detail::ProgramInput program;
  std::vector<Vec3> body_x;
  StepReport attempts;
  detail::StepLedger ledger;
  std::optional<detail::EnergyBalance> balance;  ///< none: of no member yet
  std::map<std::string, double> strain;
  double dripped = 0.0;  ///< kg
  bool uncrossed = false;
  RunResult result, before;
};

/// The parts of a simulation whose mesh stays. start.cpp has its start, advance.cpp its steps,
/// check_state.cpp the checks of its states.
struct Simulation::Parts {
  Scene scene;
  BuiltScene built;
  detail::PhaseClock clock;
  detail::StepMethods methods;
  ForceLawRegistry force_laws;
  detail::TurningBodies turning;
  detail::JoinedSteps joined;
  detail::Sleep sleep;
  ThreadArena threads;  // of the steps
  SimulationState state;
  std::vector<Vec3> body_x;  // m, of the body vertices at the state's time
  detail::StepInput input;
  detail::StepOutcome outcome;  // of the last attempt
  StepReport attempts;
  struct {
    std::int32_t vertex = -1;
    double speed = 0.0;  // m/s
  } last_motion;         // of the fastest particle in the last step
  detail::StepLedger ledger;
  detail::EnergyBalance balance;
  detail::StrainGuard strain_guard;
  std::optional<detail::Water> water;
  std::optional<detail::WrenchAccount> wrenches;  // none: not asked for
  bool uncrossed = false;  // the state, with the bodies at body_x, is proved to have no crossing
  RunResult result;        // with the present mesh
  RunResult before;        // of the parts of the run before a change of the mesh or a resume

  Parts(const Scene& s, BuiltScene b, const Methods& m);

  std::size_t n() const { return state.x.size(); }
  double nominal_step() const { return 1.0 / (scene.time.fps * scene.time.steps_per_frame); }

  // -- start.cpp ----------------------------------------------------------------------------------
  void start(const Methods& m);
  void refuse_bad_start();
  void refuse_unstable_start();
  void refuse_enclosed_start(std::span<const EdgeCrossing> crossings);
  std::vector<EdgeCrossing> start_untangling();
  void restore(SimulationState saved);
  void continue_at(SimulationState saved);
  void forget_bodies();
  Carried give();
  void take(Carried carried);

  // -- advance.cpp --------------------------------------------------------------------------------
  StepControl control() const;
  double longest_step(double h);
  double stable_step(double h, double target);
  StepControl next_control(StepControl control, double planned) const;
  void make_step(StepControl control);
  void sleep_until(double target, int nominal_steps);
  void wake() { state.still = 0.0; }
  void attempt_step(double h, double t1, bool may_shorten);
  void expect_motion(detail::Course& course) const;
  void hold_pinched(detail::Course& course);
  bool slip_pinches();
  bool gains_energy();
  bool strains_far(double h, bool may);
  void finish_velocities(std::span<Vec3> v) const;
  void note_rejection();
  bool carry_jam();
  void note_held_inside();
  void name_cause();
  [[noreturn]] void give_up();
  void accept();
  void wet(std::vector<double>& mass);
  void measure_wrenches(bool on);
  void count_substitutes();

  // -- rest.cpp -----------------------------------------------------------------------------------
  void note_motion();
  bool is_slow() const;
  bool settles() const;
  std::vector<StepContact> contacts_now();
  RestReport rest();
  double accelerating_share(std::span<const Vec3> still) const;

  // -- check_state.cpp ----------------------------------------------------------------------------
  void look_at_state();
  detail::Crossings crossings_now();
  bool steps_prove_uncrossed() const;
  bool bodies_are_in_place() const;
  void carry_proof();
  bool is_proved_uncrossed() const;
  void verify_frame();
  bool verifies_clean();
  void note_bodies(std::span<const Vec3> x);
  void note_strain();
  void note_memory();
  std::vector<std::uint8_t> flags() const;
  std::string enclosed_sentence(const detail::Enclosed& found, const char* when) const;
  void continue_untangling();
  RunResult present_result() const;
  void continue_from(RunResult earlier);
};

}  // namespace selvedge

namespace selvedge::detail {

/// The contacts of an accepted attempt with their impulses; `response` is as it was left.
std::vector<StepContact> step_contacts(const Response& response, const StepOutcome& outcome);

}  // namespace selvedge::detail
