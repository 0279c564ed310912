// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <string>

namespace selvedge::judging {

/// Throws std::invalid_argument with a message that starts with `name` if a coordinate is not
/// finite or an index is out of range. Repeated indices are allowed: the triangle is then a segment
/// or a point.
void check_surface(std::span<const Vec3> x, std::span<const Triangle> triangles,
                   const std::string& name);

}  // namespace selvedge::judging
