// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>

#include <vector>

namespace selvedge::detail {

/// Lays a flat grid along a curve: x of the grid runs along the centripetal Catmull-Rom curve
/// through the points of `path` [Yuksel2011], which has neither cusps nor loops between two points;
/// y along the part of `side` that is perpendicular to the curve. Exact up to the sampling of the
/// curve, relative 1e-5. A curve that bends towards `side` stretches one border of the cloth.
/// Throws std::invalid_argument, with the length, if the curve is not as long as the grid within 1
/// %, if two neighbouring points coincide, or if `side` runs along the curve.
std::vector<Vec3> lay_along(const StripPath& path, double size_x, const std::vector<Vec3>& flat);

}  // namespace selvedge::detail
