// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/garment/panel_mesh.h>

namespace selvedge::detail {

/// Least angle of a triangle, rad.
double least_angle_of(const Vec2& a, const Vec2& b, const Vec2& c);
/// Quality of a mesh whose first vertices are the loop.
PanelMeshQuality quality_of(std::span<const Vec2> loop, std::span<const Vec2> vertices,
                            std::span<const Triangle> triangles);

}  // namespace selvedge::detail
