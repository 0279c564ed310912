// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>

namespace selvedge {

/// Adds `fcl_dynamic_aabb_tree`: the dynamic AABB tree of the Flexible Collision Library over the
/// swept triangles, updated while the motion is coherent. Reports the same pairs as brute force.
/// Single-threaded.
void register_fcl(BroadPhaseRegistry& registry);

}  // namespace selvedge
