// SPDX-License-Identifier: MIT
//
// What a run, its replay and its pictures read about the last step of a simulation.
#pragma once

#include <selvedge/response/response.h>

#include <cstdint>
#include <string>
#include <vector>

namespace selvedge {

/// The last rejected attempt of a step.
struct RejectedAttempt {
  double h = 0.0;                   ///< s, its length; 0: no attempt was rejected
  std::string cause;                ///< why it was rejected
  std::vector<ContactPoint> pairs;  ///< that collide on the paths x_t0 -> x_t1, earliest first
  std::int32_t not_finite = -1;  ///< first particle without a finite position; -1: all are finite
  std::vector<Vec3> x_t0, x_t1;  ///< m, cloth particles, then body vertices
};

/// The attempts of the last step.
struct StepReport {
  std::vector<double> lengths;  ///< s, of all attempts, the accepted one included
  RejectedAttempt rejected;     ///< the last rejected one, of any step so far
  bool accepted = false;        ///< the last attempt was accepted, and the state follows from it
  bool given_up = false;        ///< no attempt was accepted
};

/// A contact of an accepted step.
struct StepContact {
  ContactPoint point;  ///< pair, weights, normal, rest gap; `point.gap`: at the start of the step
  double gap = 0.0;    ///< m, at the end of the step, along the normal
  /// N·s, on the first primitive; the second receives the opposite. Of the response alone: zero for
  /// a response that moves particles without impulses, and without the fail-safe's share.
  Vec3 impulse = Vec3::Zero();
};

/// Whether a step that was accepted after `halvings` of at most `max_halvings` is at most twice as
/// long as the smallest one allowed. Always false if fewer than 4 halvings are allowed, because the
/// smallest step is not yet small then.
bool is_near_smallest(int halvings, int max_halvings);

}  // namespace selvedge
