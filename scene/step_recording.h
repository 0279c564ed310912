// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/step_trace.h>

#include <string>
#include <vector>

namespace selvedge {

/// Where everything would have ended after a stage; stages of one name in a row count as one.
struct RecordedStage {
  std::string name;
  int times = 1;
  std::vector<Vec3> x_t1;  ///< m, cloth particles, then body vertices
};

/// A contact that pushed in the last solve of a try.
struct ContactLoad {
  ContactPoint contact;
  Vec3 force;  ///< N, on the first primitive
};

/// How one try of a step came about.
struct RecordedTry {
  double h = 0.0;                      ///< s; 0: there was none
  std::vector<Vec3> x_t0;              ///< m, cloth particles, then body vertices
  std::vector<double> inv_mass;        ///< 1/kg, 0 for held particles and body vertices
  std::vector<ContactPoint> contacts;  ///< near at the start, or found to collide later
  std::vector<RecordedStage> stages;   ///< the first is "coasting", before any force
  std::vector<ImplicitTerm> terms;     ///< of the last solve
  std::vector<Vec3> v;                 ///< that it gave, m/s

  /// The contacts that carried in the last solve, each with its force (rhs - matrix·Σ weight·v)/h.
  std::vector<ContactLoad> loads() const;
};

/// Keeps the last two tries: of a step that passes, the one before the last is the last that
/// failed.
class StepRecording {
 public:
  StepRecording();
  StepRecording(const StepRecording&) = delete;
  StepRecording& operator=(const StepRecording&) = delete;

  const StepTrace& trace() const { return trace_; }
  const RecordedTry& last() const { return last_; }
  const RecordedTry& last_but_one() const { return before_; }

 private:
  void begin(const TracedTry& attempt);
  void stage(const TracedStage& stage);

  StepTrace trace_;
  RecordedTry last_, before_;
};

}  // namespace selvedge
