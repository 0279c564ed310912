// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth_mesh.h>

namespace selvedge::detail {

/// The bending of a grid by the material's law: hinges, links that buckle, or twisting springs.
/// All store ½ B κ² per area for every direction of bending, as a plate with Poisson's ratio 0.
/// Throws std::invalid_argument where links or twisting springs cannot (cells above 1.73 : 1).
void add_grid_bending(ClothMesh& cloth, const GridConfig& grid, const Material& material);

/// Twisting springs in the corners of the cells, which store ½ G γ² per area and hold nothing else.
void add_grid_twist(ClothMesh& cloth, const GridConfig& grid, const Material& material);

}  // namespace selvedge::detail
