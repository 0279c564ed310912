// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/narrowphase/narrow_phase.h>

namespace selvedge {

/// The methods that a scene may name. A program that links adapters registers them here.
struct Methods {
  BroadPhaseRegistry broad_phases = selvedge::broad_phases();
  NarrowPhaseRegistry narrow_phases = selvedge::narrow_phases();
};

}  // namespace selvedge
