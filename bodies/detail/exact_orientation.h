// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/types.h>

namespace selvedge::detail {

// Signs of determinants of double coordinates: +1, 0 or -1, never wrong as long as no product of
// three (orientation in the plane: two) coordinate differences leaves the range of double, that is
// for coordinates between 1e-90 and 1e100 in size, and 0.

/// Side of d on the plane through a, b, c: +1 if a, b, c appear clockwise seen from d.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);
/// Turn a, b, c in the plane that is left when coordinate `axis` is dropped: +1 counter-clockwise
/// with the other coordinates in cyclic order.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, int axis);

}  // namespace selvedge::detail
