// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

namespace selvedge {

/// Why a run stopped before its end.
enum class FailureKind : std::uint8_t {
  not_clean,      ///< no step, however short, is free of collisions
  not_finite,     ///< a particle has no finite position
  stalled,        ///< step after step is accepted only near the smallest length
  out_of_budget,  ///< the granted time or the granted steps are used up
  unstable_step,  ///< the scene refuses to divide a step that is unstable for its integrator
};

/// "not clean", "not finite", "stalled", "out of budget", "unstable step".
const char* failure_name(FailureKind kind);
/// Throws std::invalid_argument for another name.
FailureKind failure_kind(const std::string& name);

/// The simulation cannot continue. The message names the particle or the pair.
struct SimulationFailed : std::runtime_error {
  SimulationFailed(FailureKind of_kind, const std::string& cause)
      : std::runtime_error(cause), kind(of_kind) {}
  FailureKind kind;
};

}  // namespace selvedge
