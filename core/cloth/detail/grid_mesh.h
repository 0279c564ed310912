// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/cloth_mesh.h>

namespace selvedge::detail {

/// Which diagonals of the cells are springs. `same`: all from (i,j) to (i+1,j+1). `alternating`:
/// the direction alternates like the fields of a chessboard.
enum class Diagonals { both, same, alternating };

/// Sides of a cell (m) and stiffnesses of the inner springs (N/m) of a rectangular grid.
struct CellConstants {
  double a = 0.0, b = 0.0;
  double spring_x = 0.0, spring_y = 0.0, spring_diagonal = 0.0;
  // stiffness of a border spring, which represents half a cell, relative to an inner one.
  double border_share = 0.5;
};

/// Side lengths of the cells of `grid`; the stiffnesses stay 0.
CellConstants cell_sides(const GridConfig& grid);

/// C11 and C22 of a net with C12 = C33 = g and C13 = C23 = 0 whose strip moduli (free sides) are
/// C11 - C12²/C22 = warp and C22 - C12²/C11 = weft.
struct StretchConstants {
  double warp, weft;
};
StretchConstants stretch_constants(double warp, double weft, double g);

/// Throws std::invalid_argument if the diagonals alone are stiffer than the material.
void validate_cells(const CellConstants& c, const Material& m);

/// Vertices, masses, triangles, structural and shear springs of a grid.
ClothMesh make_grid_net(const GridConfig& grid, const Material& material, const CellConstants& c,
                        Diagonals diagonals);

/// Adds hinges that store ½ B κ² per area for every direction of bending, like a plate with
/// Poisson's ratio 0: a pair for each inner edge of the grid and one for each cell, which resists
/// twist.
enum class GridHinges { all, twist };
void add_grid_hinges(ClothMesh& cloth, const GridConfig& grid, const Material& material,
                     GridHinges wanted = GridHinges::all);

}  // namespace selvedge::detail
