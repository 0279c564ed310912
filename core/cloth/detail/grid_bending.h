// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/cloth_mesh.h>

#include <functional>

namespace selvedge::detail {

/// Three particles in a line: the spacing of neighbours, and the line's part of the plate rigidity
/// times the area that the line represents.
struct GridLine {
  std::int32_t before, centre, after;
  double spacing;        // m
  double rigidity_area;  // N·m·m²
};

/// Calls `add` for the lines along rows, columns and both diagonals, which together are a plate
/// with Poisson's ratio 0. Throws std::invalid_argument for cells above 1.73 : 1.
void for_each_line(const GridConfig& grid, const Material& material,
                   const std::function<void(const GridLine&)>& add);

/// Adds the bending elements of a grid by the material's law. All store ½ B κ² per area for every
/// direction of bending, like a plate with Poisson's ratio 0.
void add_grid_bending(ClothMesh& cloth, const GridConfig& grid, const Material& material);

/// Hinges of a grid, with the measured curve and the friction of the material.
void add_hinged_grid(ClothMesh& cloth, const GridConfig& grid, const Material& material);

/// Least stiffness in N/m that a link of this rigidity (N·m²) and length (m) may have before it
/// buckles: steeper than any later slope, with room; see make_buckling_force.
double least_onset(double rigidity, double length);

}  // namespace selvedge::detail
