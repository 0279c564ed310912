// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

// Signs of determinants: +1, 0 or -1, exact for all finite doubles. A floating-point filter decides
// the easy cases, integers of any length the rest.
namespace selvedge {

/// Sign of det[a-d; b-d; c-d]: the side of d relative to the plane through a, b, c.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Sign of the area of a, b, c in the projection along `axis`, the other two coordinates in cyclic
/// order.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, int axis);

}  // namespace selvedge
