// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

namespace selvedge::detail {

/// Solid angle of a closed surface as seen from a point, over 4π: 0 outside, 1 inside, and 2 where
/// two parts of it overlap [A. Van Oosterom, J. Strackee, "The solid angle of a plane triangle",
/// 1983].
double winding_number(const TriangleMesh& body, const Vec3& point);

}  // namespace selvedge::detail
