// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/failure_bundle.h>

#include <optional>
#include <string>
#include <vector>

namespace selvedge {

/// What came of a step that was made again.
struct StepReplay {
  std::optional<FailureKind> failure;  ///< none: the step passes now
  std::string cause;                   ///< "" if it passes
  std::vector<double> tried;           ///< s, lengths of the tries, the accepted one included
  std::string state_hash;              ///< of the state afterwards
  bool as_recorded = false;            ///< same failure, same cause, same tries to the bit
};

/// Puts `simulation`, made from the scene of the bundle, into the state of the bundle and makes the
/// step that failed again. A step that was recorded as stalled fails again if it is accepted only
/// near the smallest size once more. Throws std::invalid_argument if state or bodies are not those
/// that the bundle was made with.
StepReplay replay_step(Simulation& simulation, const Scene& scene, const FailureBundle& bundle);

}  // namespace selvedge
