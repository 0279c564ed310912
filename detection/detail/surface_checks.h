// SPDX-License-Identifier: MIT
//
// Checks of arrays that a program passes. Each throws std::invalid_argument that names the surface,
// the index and the value.
#pragma once

#include <selvedge/core/base/types.h>

#include <span>
#include <string>

namespace selvedge::detail {

/// At most 2^31 - 1 vertices, all finite. `name` is the surface, `array` its member.
void check_vertices(std::span<const Vec3> x, const std::string& name, const char* array);
/// Triangles of a surface with n vertices.
void check_triangles(std::span<const Triangle> triangles, std::size_t n, const std::string& name);

}  // namespace selvedge::detail
