// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>

namespace selvedge {

/// Adds two detectors over the swept triangles, which report the same pairs as brute force:
/// - `cgal_box_intersection`: CGAL's box_intersection_d, by streamed segment trees. It keeps
/// nothing
///   between calls.
/// - `cgal_aabb_tree`: CGAL's AABB_tree of one surface, asked for each box of the other (of two
/// that
///   move, that of the one with fewer triangles). The tree of a surface that stands still is kept;
///   there is no refit. It is made during the search, so that its time counts as the query's.
///
/// This part of CGAL is under the GPL, version 3 or later: a program that links this adapter is
/// bound by it. No other part of selvedge is.
void register_cgal(BroadPhaseRegistry& registry);

}  // namespace selvedge
