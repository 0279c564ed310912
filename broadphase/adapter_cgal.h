// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>

namespace selvedge {

/// Adds `cgal_box_intersection`: CGAL's box_intersection_d, by streamed segment trees, over the
/// swept triangles. It keeps nothing between calls. Reports the same pairs as brute force.
///
/// This part of CGAL is under the GPL, version 3 or later: a program that links this adapter is
/// bound by it. No other part of selvedge is.
void register_cgal(BroadPhaseRegistry& registry);

}  // namespace selvedge
