// SPDX-License-Identifier: MIT
//
// How a step came about: a trace of its attempts, a recording of the last two, and an explanation
// of the last one that failed.
#pragma once

#include <selvedge/core/solver/integrator.h>
#include <selvedge/response/response.h>
#include <selvedge/scene/scene.h>

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

class Simulation;

/// The start of an attempt of a step.
struct TracedAttempt {
  double h = 0.0;                          ///< s
  std::span<const Vec3> x_t0, x_t1;        ///< m; x_t1 of the particles is where they would coast
  std::span<const double> inv_mass;        ///< 1/kg, 0 for held particles and body vertices
  std::span<const ContactPoint> contacts;  ///< near at the start
};

/// The end of one stage of an attempt.
struct TracedStage {
  const char* name;                     ///< "solve", "strain limit", "fail-safe", ...
  std::span<const Vec3> x_t1;           ///< m, ends of all paths after the stage
  std::span<const ContactPoint> hits;   ///< the last collisions; a collision solve answers them
  std::span<const ImplicitTerm> terms;  ///< of a solve: the contacts that carry
  std::span<const Vec3> v;              ///< of a solve: the particles' velocities, m/s
};

/// Receives the attempts of a simulation. Both functions are called on its thread; the spans are
/// valid during the call. Without a trace the simulation spends no time on it.
struct StepTrace {
  std::function<void(const TracedAttempt&)> begin;
  std::function<void(const TracedStage&)> stage;
};

/// The ends of all paths after a stage; consecutive stages of one name count as one.
struct RecordedStage {
  std::string name;
  int times = 1;
  std::vector<Vec3> x_t1;  ///< m, cloth particles, then body vertices
};

/// A contact that pushed in the last solve of an attempt.
struct ContactLoad {
  ContactPoint contact;
  Vec3 force;  ///< N, on the first primitive
};

/// The stages of one attempt of a step.
struct RecordedAttempt {
  double h = 0.0;                      ///< s; 0: there was no attempt
  std::vector<Vec3> x_t0;              ///< m, cloth particles, then body vertices
  std::vector<double> inv_mass;        ///< 1/kg, 0 for held particles and body vertices
  std::vector<ContactPoint> contacts;  ///< near at the start, or found to collide later
  std::vector<RecordedStage> stages;   ///< the first is "coasting", before any force
  std::vector<ImplicitTerm> terms;     ///< of the last solve
  std::vector<Vec3> v;                 ///< m/s, of the last solve

  /// The contacts that carried in the last solve, each with its force (rhs - matrix·Σ weight·v)/h.
  std::vector<ContactLoad> loads() const;
};

/// Keeps the last two attempts. If a step was accepted, the last but one is its last rejected
/// attempt.
class StepRecording {
 public:
  StepRecording();
  StepRecording(const StepRecording&) = delete;
  StepRecording& operator=(const StepRecording&) = delete;

  const StepTrace& trace() const { return trace_; }
  const RecordedAttempt& last() const { return last_; }
  const RecordedAttempt& last_but_one() const { return before_; }

 private:
  void begin(const TracedAttempt& attempt);
  void stage(const TracedStage& stage);

  StepTrace trace_;
  RecordedAttempt last_, before_;
};

/// A force on a particle and its origin.
struct Load {
  std::string name;
  double force = 0.0;  ///< N
};

/// A cause of a step's failure.
struct Culprit {
  std::string kind;                ///< "squeeze", "push", "carry", "pull", "meet" or "not finite"
  std::string sentence;            ///< readable by a person
  std::vector<std::string> names;  ///< the bodies, handles and pieces of cloth involved
  std::int32_t vertex = -1;        ///< where, joint index
  double motion = 0.0;             ///< m, displacement or approach in the attempt
  double room = 0.0;               ///< m, between two that squeeze, at the start of the step
  std::vector<Load> loads{};       ///< on that vertex in the last solve
};

/// A colliding pair after one stage of the attempt.
struct PairStage {
  std::string stage;
  double gap = 0.0;               ///< m, along the normal at the end of the step
  bool collides = false;          ///< on the straight paths to there, decided exactly
  std::array<double, 4> moved{};  ///< m, by the stage alone, of each vertex
};

/// The history of a pair that still collides.
struct PairExplanation {
  ContactPoint pair;
  std::string name;
  std::vector<PairStage> stages;
  std::string brought_by;  ///< the stage since which it collides
};

struct Explanation {
  double h = 0.0;                      ///< s, length of the explained attempt
  std::vector<Culprit> culprits;       ///< largest motion first; at least one
  std::vector<PairExplanation> pairs;  ///< at most kExplainedPairs
  std::size_t colliding_pairs = 0;
};

/// Number of pairs that are explained stage by stage.
inline constexpr std::size_t kExplainedPairs = 8;

/// Explains the last rejected attempt of `simulation`, of which `attempt` is the recording. From
/// the particles that collide it follows the contacts, through any number of layers of cloth, to
/// the bodies and handles that move.
Explanation explain_step(const Scene& scene, const Simulation& simulation,
                         const RecordedAttempt& attempt);

}  // namespace selvedge
