// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/detail/polynomial.h>
#include <selvedge/narrowphase/narrow_phase.h>

namespace selvedge::narrowphase_detail {

/// Decides a query of finite doubles in integer arithmetic: no rounding anywhere. If the primitives
/// collide, toi is the largest double not later than the true time of impact.
bool collides_exactly(const Query& query, double& toi);

/// The largest double not above the root of the coplanarity cubic in the box [k, k + 1] / 2^m.
/// False if the cubic may have none or more than one root there.
bool root_in_box(const Query& query, std::int64_t k, int m, double& root);

/// Exponent of the lowest set bit of x, which is finite and not zero.
int lowest_bit(double x);

/// The coplanarity cubic of the four vertices, times a power of two; possibly identically zero.
Polynomial coplanarity_cubic(const Query& query);

}  // namespace selvedge::narrowphase_detail
