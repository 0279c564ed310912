// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/detail/ccd_filter.h>
#include <selvedge/narrowphase/detail/polynomial.h>
#include <selvedge/narrowphase/detail/root_isolation.h>
#include <selvedge/narrowphase/narrow_phase.h>

namespace selvedge::detail {

/// Decides a query of finite doubles in integer arithmetic, without rounding. If the primitives
/// collide, toi is the largest double not later than the true time of impact.
bool collides_exactly(const FilterKernel& kernel, const Query& query, double& toi);

/// Whether the primitives touch at a root of the coplanarity cubic found by stage C; if so,
/// root.floor is then the largest double not above it.
bool touches_exactly(const Query& query, IsolatedRoot& root);

/// The coplanarity cubic of the four vertices, times a power of two; may be identically zero.
Polynomial<BigInt> coplanarity_cubic(const Query& query);

}  // namespace selvedge::detail
