// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth_mesh.h>

namespace selvedge::detail {

/// Which diagonals of the cells of a grid are springs. `same`: all from (i,j) to (i+1,j+1).
/// `alternating`: the other one in every second cell, like the black fields of a chessboard.
enum class Diagonals { both, same, alternating };

/// Sides of a cell (m) and stiffnesses of the inner springs (N/m) of a rectangular grid.
struct CellConstants {
  double a = 0.0, b = 0.0;
  double spring_x = 0.0, spring_y = 0.0, spring_diagonal = 0.0;
  double border_share = 0.5;  // of a spring on the border, which stands for half a cell
};

/// Sides of the cells of `grid`; the stiffnesses are left at 0.
CellConstants cell_sides(const GridConfig& grid);

/// C11 and C22 of a net with C12 = C33 = g, C13 = C23 = 0 and the strip moduli (free sides)
/// C11 - C12²/C22 = warp, C22 - C12²/C11 = weft.
struct StretchConstants {
  double warp, weft;
};
StretchConstants stretch_constants(double warp, double weft, double g);

/// Throws std::invalid_argument where the diagonals alone are stiffer than the material.
void validate_cells(const CellConstants& c, const Material& m);

/// Vertices, masses, triangles, structural and shear springs of a grid.
ClothMesh make_grid_net(const GridConfig& grid, const Material& material, const CellConstants& c,
                        Diagonals diagonals);

/// Hinges that store ½ B κ² per area for every direction of bending: those of a plate with
/// Poisson's ratio 0. One pair for each inner edge of the grid, one for each cell.
void add_grid_hinges(ClothMesh& cloth, const GridConfig& grid, const Material& material);

}  // namespace selvedge::detail
