// SPDX-License-Identifier: MIT
//
// A step as a value: attempt_step takes its input and gives its outcome, and so does each stage.
#pragma once

#include <selvedge/core/solver/integrator.h>
#include <selvedge/response/response.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/contacts/detail/detection.h>
#include <selvedge/simulation/detail/pinches.h>
#include <selvedge/simulation/detail/program_input.h>
#include <selvedge/simulation/detail/sewing.h>
#include <selvedge/simulation/detail/solids.h>
#include <selvedge/simulation/detail/strain_stage.h>
#include <selvedge/simulation/detail/untangle.h>
#include <selvedge/simulation/detail/validate_step.h>
#include <selvedge/simulation/internal/explain_step.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/simulation/step_report.h>

#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

/// The methods of a scene that compute a step.
struct StepMethods {
  StepMethods(const Scene& scene, const BuiltScene& built, const Methods& methods,
              PhaseClock& clock);

  const Scene& scene;
  ProgramInput program;  ///< before the integrator, whose forces refer to it
  Detection detection;
  StrainStage strain;
  Followers followers;  ///< empty: no particle follows others
  Followers layers;     ///< dense layers that follow sparse ones; empty: none
  std::unique_ptr<Integrator> integrator;
  IntegratorTraits traits;  ///< of the integrator
  std::unique_ptr<Response> response;
  std::unique_ptr<FailSafe> fail_safe;
  std::unique_ptr<Untangler> untangler;  ///< null: the scene neither untangles nor carries jams on
  Sewing sewing;
  JointStops stops;
  VertexNames names;
  Pinches pinches;
  StepValidator validator;  ///< used in validation builds
  PhaseClock& clock;
  const StepTrace* trace = nullptr;
  bool notes_stages = false;  ///< fills StepEnds::given

  bool untangling() const { return untangler && untangler->active(); }
};

/// Input of a step. Joint arrays hold cloth particles first, then the vertices of all bodies.
struct StepInput {
  std::int64_t step = 0;               ///< accepted steps so far
  double t0 = 0.0, t1 = 0.0, h = 0.0;  ///< s
  double nominal_h = 0.0;              ///< s, of a step that the scene requests
  Particles particles;                 ///< at t0
  std::vector<Vec3> x_t0;              ///< m, joint
  std::vector<double> inv_mass;        ///< 1/kg, joint; 0 for held particles and body vertices
  /// kg, of the particles as contacts feel them, if some are vertices of rigid bodies; else empty
  std::vector<double> contact_mass;
  std::vector<Vec3> body_step;  ///< m, displacement of the body vertices
  /// m/s, of particles under their weight and the forces of the program alone
  std::vector<Vec3> v_coasting;
  bool bodies_move = false;
  bool settles = false;  ///< the scene asks for the equilibrium, which is near
  /// An attempt that ends farther above the strain limit than this (by the limit) and than its
  /// start is repeated with a shorter step in any case.
  double hopeless_strain = std::numeric_limits<double>::infinity();
  const Followers* followers = nullptr;   ///< null: no particle follows others
  const ProgramInput* program = nullptr;  ///< what the program has set

  /// Restores that followers follow, after something has moved single particles: positions in m or
  /// velocities in m/s.
  void keep_followers(std::span<Vec3> ends) const {
    if (followers != nullptr)
      followers->hand_over(particles.mass, std::span(inv_mass).first(n()), ends);
  }
  std::size_t n() const { return particles.x.size(); }
};

/// Counts of one attempt.
struct StepCounts {
  std::size_t contacts = 0;  ///< near at the start
  int candidate_rebuilds = 0;
  int solves = 0, solver_iterations = 0, solves_not_converged = 0;
  std::size_t solver_bytes = 0;    ///< moved by the solver
  int strain_sweeps = -1;          ///< -1: the scene limits no strain
  double max_gap_violation = 0.0;  ///< m, of a contact at the start

  StepCounts& operator+=(const StepCounts& other);
  /// Adds the counts to those of a run, by the names that result.json has.
  void add_to(std::map<std::string, double>& counters) const;
};

// What the stages of a step give; each takes what the one before it gave.

/// The start: bodies and held particles at their prescribed ends, pinched cloth where its surfaces
/// take it, all other particles where they would go without contacts.
struct Course {
  std::vector<Vec3> x_t1;        ///< m, joint, ends of the paths
  std::vector<Vec3> v_mean;      ///< m/s, of the particles
  std::vector<Pinch> pinches{};  ///< that hold during the step
};

/// The contacts near the start.
struct NearContacts {
  std::vector<ContactPoint> points;
  std::vector<Pinch> pinches;  ///< that hold during the step
  /// Bodies come to pinch cloth during the step, which was not known when it began: the attempt
  /// begins again with the same length.
  bool pinches_more = false;
};

/// The velocities of the particles that a solve gave, m/s.
struct SolvedVelocities {
  std::vector<Vec3> mean;  ///< of the step
  std::vector<Vec3> free;  ///< at its end, without contacts and limits unless the solve had them
  bool answered = false;   ///< the last solve had terms of the response
};

/// The ends of the paths, after the response and the strain limits.
struct StepEnds {
  std::vector<Vec3> x_t1;                  ///< m, joint
  std::vector<Vec3> x_free{};              ///< m, without both; empty: those of the mean velocities
  std::optional<Ledger> response{};        ///< what the response exchanged
  std::vector<ContactPoint> collisions{};  ///< on these paths, earliest first
  /// By name, the impulses that stages after the solve gave to the free particles, N·s and N·m·s;
  /// empty unless they are asked for.
  std::map<std::string, Wrench> given{};
};

/// Why an attempt has to be repeated with a shorter step.
struct Rejection {
  std::string cause;             ///< empty if a particle has no finite position
  std::int32_t not_finite = -1;  ///< first particle without a finite position; -1: all are finite
};

/// Forces, contacts and friction.
struct Solution {
  SolvedVelocities v;
  StepEnds ends;
  std::vector<ContactPoint> met{};  ///< found to collide and answered as further contacts
  std::optional<Rejection> rejection{};
  StepCounts counts{};
};

/// Collisions and strain limits together.
struct Parting {
  StepEnds ends;
  Ledger fail_safe{};            ///< what the fail-safe exchanged
  std::vector<Vec3> x_tested{};  ///< m, joint, ends of the paths that the fail-safe saw last
  bool over_strain = false;      ///< a bounding limiter left springs above their limit
  std::optional<Rejection> rejection{};
  StepCounts counts{};
};

/// Outcome of an attempt.
struct StepOutcome {
  NearContacts near{};
  SolvedVelocities v{};
  std::vector<ContactPoint> met{};  ///< see Solution
  Parting parting{};
  StepCounts counts{};

  bool accepted() const { return !near.pinches_more && !parting.rejection; }
  std::span<const Vec3> x_t1() const { return parting.ends.x_t1; }
};

/// Fills the input of a step of `state` to the time t1, and gives its course: bodies and held
/// particles at their prescribed ends and all other particles where they would coast.
Course begin_step(const Scene& scene, const BuiltScene& built, const SimulationState& state,
                  StepInput& input);
/// The part of begin_step that sets masses and the prescribed ends of held particles, x_t1.
void hold_particles(const Scene& scene, const BuiltScene& built, const SimulationState& state,
                    StepInput& input, std::span<Vec3> x_t1);
/// Whether a body of the scene may move between the times t0 and t1, s.
bool bodies_move(const BuiltScene& built, double t0, double t1);
/// Writes the positions of all bodies at a time to the end of the joint array x, m.
void place_bodies(const BuiltScene& built, double time, std::span<Vec3> x);

/// Computes a step: forces and contacts, strain limits, collisions, fail-safe. An accepted attempt
/// has no collision on its paths, as far as the narrow phase of the scene can tell.
StepOutcome attempt_step(StepMethods& methods, const StepInput& input, Course course);

/// Velocities of the particles at the end of an attempt, m/s. The displacement by contacts and
/// limits is added to the velocity that the integrator has there: free flight keeps its order, and
/// any contact that stops a particle also stops its velocity.
void end_velocities(const IntegratorTraits& traits, const StepInput& input,
                    const StepOutcome& outcome, std::span<Vec3> v);

/// The step as responses and limiters see it; views of `input`.
ResponseStep response_step(const StepMethods& methods, const StepInput& input);
/// The same with the true masses, for ledgers.
ResponseStep ledger_step(const StepMethods& methods, const StepInput& input);
LimitStep limit_step(const StepInput& input);

}  // namespace selvedge::detail
