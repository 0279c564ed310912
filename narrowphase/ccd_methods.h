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
/// tolerance: what a simulator does first, and the baseline of every figure of speed.
std::unique_ptr<NarrowPhase> make_ccd_cubic(const NarrowPhaseConfig& config = {});

/// [Provot1997]: the same with a tolerance on the barycentric coordinates of the inside test,
/// `tolerance`, dimensionless, default 1e-6.
std::unique_ptr<NarrowPhase> make_ccd_cubic_provot(const NarrowPhaseConfig& config = {});

/// [Bridson2002]: at each root, and at the end of the step, the primitives collide if they are
/// nearer than `tolerance`, metres, default 1e-8.
std::unique_ptr<NarrowPhase> make_ccd_cubic_bridson(const NarrowPhaseConfig& config = {});

}  // namespace selvedge
