// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>

// Each function is in a library of its own: selvedge::broadphase_fcl, selvedge::broadphase_cgal,
// selvedge::broadphase_embree. A build that does not find the package omits that library.

namespace selvedge {

/// Adds `fcl_dynamic_aabb_tree`: the dynamic AABB tree of the Flexible Collision Library over the
/// swept triangles, updated while the motion is coherent. Reports the same pairs as brute force.
/// Single-threaded.
void register_fcl(BroadPhaseRegistry& registry);

/// Adds two detectors over the swept triangles, which report the same pairs as brute force:
/// - `cgal_box_intersection`: CGAL's box_intersection_d, by streamed segment trees. It keeps
///   nothing between calls.
/// - `cgal_aabb_tree`: CGAL's AABB_tree of one surface, queried with each box of the other. If both
///   surfaces move, the tree is that of the surface with fewer triangles. The tree of a static
///   surface is kept; there is no refit. The tree is built during the search, so its time counts as
///   query time.
///
/// This part of CGAL is under the GPL, version 3 or later, and so is a program that links this
/// adapter. No other part of selvedge is.
void register_cgal(BroadPhaseRegistry& registry);

/// Adds `embree_collide`: rtcCollide of Embree over the boxes of the swept triangles, passed as
/// user geometry. Reports the same pairs as brute force.
void register_embree(BroadPhaseRegistry& registry);

}  // namespace selvedge
