// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

namespace selvedge {

/// Adds `libccd_gjk` and `libccd_mpr`: whether the convex hulls that two primitives sweep overlap,
/// after Gilbert, Johnson and Keerthi or by Minkowski portal refinement, as the library libccd does
/// it. Overlap of swept hulls is only necessary for a collision, so the step is halved until the
/// relative motion within an interval is at most `tolerance` (no unit: part of the primitives'
/// size; 2^-10 by default). What then still overlaps is reported, with the start of its interval as
/// time: pairs that come nearer than about that part of their size are false alarms. The library
/// decides in doubles with absolute tolerances: on pairs scaled to size one it was never seen to
/// miss a transversal hit, but it promises nothing. Has no minimum separation.
void register_libccd(NarrowPhaseRegistry& registry);

}  // namespace selvedge
