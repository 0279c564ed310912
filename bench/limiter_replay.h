// SPDX-License-Identifier: MIT
//
// Times the strain limiters alone, on the same ends of steps and to the same residual.
#pragma once

#include <string>

namespace selvedge::bench {

struct ReplayOptions {
  int cells = 49;          ///< along a side of the cloth
  int seeds = 5;           ///< drapes, each from other velocities at the start
  int most = 100;          ///< steps of each drape that are taken
  double stiffness = 3.0;  ///< N/m, of all springs
  double seconds = 2.5;    ///< of each drape
};

/// Drapes a net of equal springs over a round table, keeps the ends of its steps before the limiter
/// changes them, and lets each limiter change a copy of each of them. Returns two tables: every
/// limiter until the limits hold, and single sweeps beside the other order at their residual.
std::string replay_limiters(const ReplayOptions& options);

}  // namespace selvedge::bench
