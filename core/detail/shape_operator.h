// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth_mesh.h>

#include <span>

namespace selvedge::detail {

/// Hinges on the inner edges of a triangle mesh and the couples between them, such that the cloth
/// is a plate of Poisson's ratio 0 on any mesh: bent to a constant curvature in any direction it
/// stores ½ B κ² per area, and no inner vertex feels a force. `rest`: positions of cloth.surface at
/// rest, m. Where they lie in a plane of constant z, x is the warp and y the weft; elsewhere both
/// have the mean of their rigidities, as there is no direction to tell them by. Border edges, and
/// those of more than two triangles, are free: no moment acts across them. With a
/// bending_friction, the loop of a cylinder of any direction is as wide as the material says.
void add_shape_operator(ClothMesh& cloth, std::span<const Vec3> rest, const Material& material);

}  // namespace selvedge::detail
