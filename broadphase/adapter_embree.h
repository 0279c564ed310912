// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>

namespace selvedge {

/// Adds `embree_collide`: rtcCollide of Embree over the swept triangles, given to it as user
/// geometry. Reports the same pairs as brute force.
void register_embree(BroadPhaseRegistry& registry);

}  // namespace selvedge
