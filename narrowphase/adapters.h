// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

// Each function is in a library of its own: selvedge::narrowphase_fcl,
// selvedge::narrowphase_libccd. A build that does not find the package omits that library.

namespace selvedge {

/// Adds `fcl_vertex_face_edge_edge`: the vertex-face and edge-edge tests over straight paths of the
/// Flexible Collision Library, which solve a coplanarity cubic by interval Newton iteration. For
/// comparison only, never a default: it misses motion that stays coplanar, degenerate primitives
/// and parallel edges, and its inside tests have absolute tolerances. The adapter makes these
/// relative by moving and scaling each pair to primitives of size one; unscaled, FCL misses 43 % of
/// vertex-face and 99 % of edge-edge collisions between primitives of 1 cm in metres. Has no
/// tolerance option and no minimum separation. (FCL's own continuousCollide ignores the motion of
/// vertices.)
void register_fcl(NarrowPhaseRegistry& registry);

/// Adds `libccd_gjk` and `libccd_mpr`, which test whether the convex hulls that two primitives
/// sweep overlap, with the library libccd: by the algorithm of Gilbert, Johnson and Keerthi, or by
/// Minkowski portal refinement. Overlapping swept hulls are only a necessary condition of a
/// collision. The step is therefore halved until the relative motion within an interval is at most
/// `tolerance` (a dimensionless fraction of the primitives' size; default 2^-10). An interval that
/// still overlaps is reported as a collision at its start: pairs that come nearer than about that
/// fraction of their size are false alarms. The library works in doubles with absolute tolerances.
/// On pairs scaled to size one it has never been observed to miss a transversal collision, but it
/// guarantees nothing. Has no minimum separation.
void register_libccd(NarrowPhaseRegistry& registry);

}  // namespace selvedge
