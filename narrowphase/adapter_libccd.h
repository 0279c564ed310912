// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

namespace selvedge {

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
