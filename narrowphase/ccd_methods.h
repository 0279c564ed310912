// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <memory>

// The published methods beside ccd_exact, for comparison and for what is built on them. None is a
// substitute for ccd_exact where a collision must not be missed unless its traits say so.
//
// A tolerance that is not a number, and a minimum separation asked of a method that has none, are
// refused by std::invalid_argument.

namespace selvedge {

/// Roots of the coplanarity cubic in plain doubles and an inside test at each, without any
/// tolerance (the config's is not used): what a simulator does first, and the baseline of every
/// figure of speed.
std::unique_ptr<NarrowPhase> make_ccd_cubic(const NarrowPhaseConfig& config = {});

/// [Provot1997]: the same with a tolerance on the barycentric coordinates of the inside test,
/// `tolerance`, dimensionless, default 1e-6.
std::unique_ptr<NarrowPhase> make_ccd_cubic_provot(const NarrowPhaseConfig& config = {});

/// [Bridson2002]: at each root, and at the end of the step, the primitives collide if they are
/// nearer than `tolerance`, metres, default 1e-8.
std::unique_ptr<NarrowPhase> make_ccd_cubic_bridson(const NarrowPhaseConfig& config = {});

/// [survey] eq. (39), a point against the plane of a triangle at both ends of the step;
/// approximate. `tolerance` as of ccd_cubic_provot, default 0. Reports no edge pairs.
std::unique_ptr<NarrowPhase> make_plane_crossing(const NarrowPhaseConfig& config = {});

/// [ZhongXu2009], [survey] section 6.1.2: edges moved by the velocity of a centroid; approximate.
/// `tolerance`: how far along the motion an edge is sought, metres, default the way of the step.
/// Reports no point-triangle pairs.
std::unique_ptr<NarrowPhase> make_centroid_velocity(const NarrowPhaseConfig& config = {});

/// Nearer than `tolerance`, metres, default 1e-3, at the start or the end of the step; blind to
/// what happens between. A minimum separation raises the tolerance to it.
std::unique_ptr<NarrowPhase> make_proximity(const NarrowPhaseConfig& config = {});

}  // namespace selvedge
