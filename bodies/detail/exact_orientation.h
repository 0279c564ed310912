// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

namespace selvedge::detail {

// Signs of determinants of double coordinates: +1, 0 or -1. The sign is exact if no product of
// three coordinate differences (two for the orientation in the plane) overflows or underflows. This
// holds for coordinates that are 0 or between 1e-90 and 1e100 in magnitude.

/// Side of d relative to the plane through a, b, c: +1 if a, b, c appear clockwise from d.
int exact_side(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);
/// Orientation of a, b, c projected along coordinate `axis`: +1 if counter-clockwise, with the
/// other two coordinates in cyclic order.
int exact_side(const Vec3& a, const Vec3& b, const Vec3& c, int axis);

}  // namespace selvedge::detail
