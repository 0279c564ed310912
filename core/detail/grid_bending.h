// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth_mesh.h>

namespace selvedge::detail {

/// Adds the bending elements of a grid by the material's law: hinges, buckling links or twisting
/// springs. All store ½ B κ² per area for every direction of bending, like a plate with Poisson's
/// ratio 0. Throws std::invalid_argument if links or twisting springs cannot do so (cells above
/// 1.73 : 1).
void add_grid_bending(ClothMesh& cloth, const GridConfig& grid, const Material& material);

/// Adds twisting springs at the corners of the cells. They store ½ G γ² per area and resist only
/// shear.
void add_grid_twist(ClothMesh& cloth, const GridConfig& grid, const Material& material);

/// Least stiffness in N/m that a link of this rigidity (N·m²) and length (m) may have before it
/// buckles: steeper than any later slope, with room; see make_buckling_force.
double least_onset(double rigidity, double length);

}  // namespace selvedge::detail
