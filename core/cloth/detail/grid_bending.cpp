// SPDX-License-Identifier: MIT
//
// Bending of a grid by lines of three particles p-t, p, p+t along the four directions t: rows,
// columns and both diagonals. If the cloth is bent to curvature κ along n, a line along t has the
// curvature κ (n·t̂)². With the fractions A and C of the rigidity for rows and columns and D for
// each diagonal, the energy per area is
//   ½ κ² [A c⁴ + C s⁴ + D (2 a⁴c⁴ + 12 a²b² c²s² + 2 b⁴s⁴)/l⁴],  n = (c,s),  l² = a² + b²,
// which equals that of the plate, ½ κ² (√B c² + √B' s²)² [Peirce1930], for
//   D = √(BB') l⁴/(6 a²b²),  A = B - √(BB') a²/(3 b²),  C = B' - √(BB') b²/(3 a²).
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/grid_bending.h>
#include <selvedge/core/cloth/detail/grid_mesh.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric_laws.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <sstream>
#include <stdexcept>

namespace selvedge::detail {
namespace {

/// Parts of the plate rigidity for rows, columns and each diagonal, N·m.
struct LineShares {
  double row, column, diagonal;
};

LineShares line_shares(const CellConstants& c, const Material& m) {
  const double warp = m.bending_stiffness, weft = bending_along_weft(m);
  const double a2 = c.a * c.a, b2 = c.b * c.b, l2 = a2 + b2, between = std::sqrt(warp * weft);
  const LineShares shares{warp - between * a2 / (3.0 * b2), weft - between * b2 / (3.0 * a2),
                          between * l2 * l2 / (6.0 * a2 * b2)};
  if (shares.row > 0.0 && shares.column > 0.0) return shares;
  std::ostringstream text;
  text << "bending_law: buckling links and twisting springs need cells whose sides differ by less "
          "than "
          "1.73 to 1 if warp and weft bend alike, not "
       << c.a << " m by " << c.b << " m of " << warp << " and " << weft
       << " N*m; change cells_x or cells_y, or use \"hinge\"";
  throw std::invalid_argument(text.str());
}

}  // namespace

void for_each_line(const GridConfig& grid, const Material& material,
                   const std::function<void(const GridLine&)>& add) {
  const CellConstants c = cell_sides(grid);
  const LineShares share = line_shares(c, material);
  const double area = c.a * c.b, diagonal = elementary::hypot(c.a, c.b);
  const std::int32_t nx = grid.cells_x, ny = grid.cells_y, up = nx + 1;
  for (std::int32_t j = 0; j <= ny; ++j)
    for (std::int32_t i = 0; i <= nx; ++i) {
      const std::int32_t p = j * up + i;
      const bool inner_x = i > 0 && i<nx, inner_y = j> 0 && j < ny;
      // A line on the border represents half a cell.
      if (inner_x) add({p - 1, p, p + 1, c.a, share.row * area * (inner_y ? 1.0 : 0.5)});
      if (inner_y) add({p - up, p, p + up, c.b, share.column * area * (inner_x ? 1.0 : 0.5)});
      if (!inner_x || !inner_y) continue;
      add({p - up - 1, p, p + up + 1, diagonal, share.diagonal * area});
      add({p + up - 1, p, p - up + 1, diagonal, share.diagonal * area});
    }
}

namespace {

// If the cloth is bent to curvature κ along n = (c,s), rows have the curvature κ c² and columns κ
// s². Frictions HB along both do the work HB κ (c² + s²) = HB κ in every direction, so twist needs
// none. A hinge of rows a × b with span d (θ = κ d) represents half a cell: moment HB a b/(2 d).
void add_bending_friction(ClothMesh& cloth, const GridConfig& grid, const Material& m) {
  if (m.bending_friction <= 0.0) return;
  const CellConstants c = cell_sides(grid);
  for (const Hinge& hinge : cloth.hinges) {
    const std::int32_t along = std::abs(hinge.v[3] - hinge.v[2]);
    if (along != 1 && along != grid.cells_x + 1) continue;  // a diagonal
    const double span = along == 1 ? c.b : c.a;
    cloth.hinge_frictions.push_back({hinge.v, hinge.rest_angle,
                                     m.bending_friction * c.a * c.b / (2.0 * span),
                                     kYieldCurvature * span});
  }
}

// A hinge along a row or column represents the area k d²/B, of its stiffness k.
void add_bending_curve(ClothMesh& cloth, const GridConfig& grid, const Material& m) {
  if (m.bending_curve.empty()) return;
  if (grid.cells_x == 1) throw std::invalid_argument("bending_curve needs at least 2 cells_x");
  const CellConstants c = cell_sides(grid);
  const std::array<std::int32_t, 2> shapes = add_bending_shapes(cloth, m);
  const std::array<double, 2> rigidity{m.bending_stiffness, bending_along_weft(m)};
  for (std::size_t h = 0; h < cloth.hinges.size(); ++h) {
    const Hinge& hinge = cloth.hinges[h];
    const std::int32_t along = std::abs(hinge.v[3] - hinge.v[2]);
    if (along != 1 && along != grid.cells_x + 1) continue;  // a diagonal
    const int direction = along == 1 ? 1 : 0;
    const double span = along == 1 ? c.b : c.a;
    if (rigidity[direction] <= 0.0) continue;
    Vec3 curvature = Vec3::Zero();
    curvature[direction] = 1.0 / span;
    cloth.curvature_curves.push_back({{{static_cast<std::int32_t>(h), curvature}},
                                      hinge.stiffness * span * span / rigidity[direction],
                                      rigidity,
                                      shapes});
  }
}

}  // namespace

void add_grid_bending(ClothMesh& cloth, const GridConfig& grid, const Material& material) {
  if (material.bending_stiffness <= 0.0) return;
  const BendingLaw& law = bending_law_of(material);
  if (material.bending_friction > 0.0 && grid.cells_x == 1)
    throw std::invalid_argument("bending_friction needs at least 2 cells_x");
  require_reader_of_bending_friction(material);
  law.add_to_grid(cloth, grid, material);
}

void add_hinged_grid(ClothMesh& cloth, const GridConfig& grid, const Material& material) {
  add_grid_hinges(cloth, grid, material);
  add_bending_curve(cloth, grid, material);
  add_bending_friction(cloth, grid, material);
}

}  // namespace selvedge::detail
