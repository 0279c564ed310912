// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>

namespace selvedge {

/// Adds `embree_collide`: rtcCollide of Embree over the boxes of the swept triangles, passed as
/// user geometry. Reports the same pairs as brute force.
void register_embree(BroadPhaseRegistry& registry);

}  // namespace selvedge
