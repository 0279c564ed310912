// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <string>

namespace selvedge::judging {

/// Throws std::invalid_argument, starting with `name`, for a coordinate that is not finite or an
/// index out of range. Repeated indices are legal: the triangle is a segment or a point.
void check_surface(std::span<const Vec3> x, std::span<const Triangle> triangles,
                   const std::string& name);

}  // namespace selvedge::judging
