// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/simulation/contacts/detail/detection_plan.h>
#include <selvedge/simulation/contacts/detail/phase_clock.h>
#include <selvedge/simulation/contacts/detail/scene_motion.h>

namespace selvedge::detail {

/// What all parts of the detection share: the motion, the proofs and the clock. Views.
struct SearchContext {
  const SceneMotion& motion;
  DetectionPlan& plan;
  PhaseClock& clock;
  double rest_gap = 0.0;  ///< m, the largest rest gap of all pairs, so that no pair is missed
  bool self = true;       ///< the cloth is tested against itself
};

}  // namespace selvedge::detail
