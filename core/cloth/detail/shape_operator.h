// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/cloth_mesh.h>

#include <span>

namespace selvedge::detail {

/// Adds hinges on the inner edges of a triangle mesh, and couplings between them, such that the
/// cloth behaves as a plate of Poisson's ratio 0 on any mesh: bent to a constant curvature in any
/// direction it stores ½ B κ² per area, and no inner vertex feels a force. `rest`: rest positions
/// of cloth.surface, m. If they lie in a plane of constant z, x is the warp and y the weft;
/// otherwise both directions have the mean rigidity. Border edges and edges of more than two
/// triangles are free: no moment acts across them. With a bending_friction, the loop of a cylinder
/// of any direction has the width given by the material.
void add_shape_operator(ClothMesh& cloth, std::span<const Vec3> rest, const Material& material);

}  // namespace selvedge::detail
