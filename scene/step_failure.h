// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/types.h>
#include <selvedge/response/contact_point.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge {

/// Why a run stopped before its end.
enum class FailureKind : std::uint8_t {
  not_clean,      ///< no step, however short, is free of collisions
  not_finite,     ///< a particle has no finite position
  stalled,        ///< step after step is accepted only near the smallest size
  out_of_budget,  ///< the time or the steps that were granted are used up
  unstable_step,  ///< the scene refuses to divide a step that its integrator does not bear
};

/// "not clean", "not finite", "stalled", "out of budget", "unstable step".
const char* failure_name(FailureKind kind);
/// Throws std::invalid_argument for another name.
FailureKind failure_kind(const std::string& name);

/// Whether a step that was accepted after `halvings` of at most `max_halvings` is at most twice as
/// long as the smallest one allowed. Never where the smallest is not yet small: fewer than 4
/// halvings are no stall.
bool is_near_smallest(int halvings, int max_halvings);

/// The last try of a step that did not come out clean.
struct FailedTry {
  double h = 0.0;                   ///< s, its length; 0: there was none
  std::string trouble;              ///< what stood against it
  std::vector<ContactPoint> pairs;  ///< that collide on the paths x_t0 -> x_t1, earliest first
  std::int32_t not_finite = -1;     ///< first particle without a finite position; -1: none
  std::vector<Vec3> x_t0, x_t1;     ///< cloth particles, then body vertices, m
};

/// The run cannot go on: diverged, or a step that cannot be made clean. Says which particle or
/// pair, by name.
class SimulationFailed : public std::runtime_error {
 public:
  SimulationFailed(FailureKind of_kind, const std::string& cause)
      : std::runtime_error(cause), kind(of_kind) {}
  FailureKind kind;
};

}  // namespace selvedge
