// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/integrator.h>
#include <selvedge/response/contact_point.h>

#include <functional>
#include <span>

namespace selvedge {

/// A try of a step begins.
struct TracedTry {
  double h = 0.0;                          ///< s
  std::span<const Vec3> x_t0, x_t1;        ///< m; x_t1 of the particles is where they would coast
  std::span<const double> inv_mass;        ///< 1/kg, 0 for held particles and body vertices
  std::span<const ContactPoint> contacts;  ///< near at the start
};

/// One stage of a try is over.
struct TracedStage {
  const char* name;                     ///< "solve", "strain limit", "fail-safe", ...
  std::span<const Vec3> x_t1;           ///< where everything would end now, m
  std::span<const ContactPoint> hits;   ///< found last to collide; a collision solve answers them
  std::span<const ImplicitTerm> terms;  ///< of a solve: the contacts that carry
  std::span<const Vec3> v;              ///< of a solve: the particles' velocities, m/s
};

/// Who wants to see how a step comes about. Both are called on the thread of the simulation; the
/// spans are valid during the call. Without a trace the simulation does nothing for it.
struct StepTrace {
  std::function<void(const TracedTry&)> begin;
  std::function<void(const TracedStage&)> stage;
};

}  // namespace selvedge
