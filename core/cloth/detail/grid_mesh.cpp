// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/grid_mesh.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric_laws.h>

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace selvedge::detail {
namespace {

std::int32_t vertex(const GridConfig& grid, std::int32_t i, std::int32_t j) {
  return j * (grid.cells_x + 1) + i;
}

class GridNet {
 public:
  GridNet(const GridConfig& grid, const Material& material, const CellConstants& constants,
          Diagonals diagonals)
      : grid_(grid), material_(material), constants_(constants), diagonals_(diagonals) {}

  ClothMesh build() {
    add_vertices();
    add_triangles();
    add_springs();
    return std::move(cloth_);
  }

 private:
  std::int32_t index(std::int32_t i, std::int32_t j) const { return vertex(grid_, i, j); }

  /// True if the diagonal of the surface in this cell starts at its lower left corner.
  bool rises(std::int32_t i, std::int32_t j) const {
    return diagonals_ == Diagonals::same || (i + j) % 2 == 0;
  }

  void add_vertices() {
    // A vertex gets a quarter of each cell around it.
    const double quarter = 0.25 * material_.density * constants_.a * constants_.b;
    for (std::int32_t j = 0; j <= grid_.cells_y; ++j)
      for (std::int32_t i = 0; i <= grid_.cells_x; ++i) {
        cloth_.surface.vertices.emplace_back(i * constants_.a - 0.5 * grid_.size_x,
                                             j * constants_.b - 0.5 * grid_.size_y, 0.0);
        const int wide = i == 0 || i == grid_.cells_x ? 1 : 2;
        const int high = j == 0 || j == grid_.cells_y ? 1 : 2;
        cloth_.mass.push_back(quarter * wide * high);
      }
  }

  void add_triangles() {
    for (std::int32_t j = 0; j < grid_.cells_y; ++j)
      for (std::int32_t i = 0; i < grid_.cells_x; ++i) {
        const std::int32_t v00 = index(i, j), v10 = index(i + 1, j);
        const std::int32_t v01 = index(i, j + 1), v11 = index(i + 1, j + 1);
        // Alternating diagonals: no direction is preferred.
        if (rises(i, j)) {
          cloth_.surface.triangles.push_back({v00, v10, v11});
          cloth_.surface.triangles.push_back({v00, v11, v01});
        } else {
          cloth_.surface.triangles.push_back({v00, v10, v01});
          cloth_.surface.triangles.push_back({v10, v11, v01});
        }
      }
    cloth_.edges = unique_edges(cloth_.surface.triangles);
  }

  void add_spring(std::int32_t a, std::int32_t b, double length, double stiffness) {
    if (stiffness <= 0.0) return;  // no shear stiffness: no diagonal springs
    cloth_.springs.push_back({a, b, length, stiffness, material_.spring_damping});
    cloth_.strain_limit.push_back(material_.strain_limit);
  }

  void add_springs() {
    const CellConstants& c = constants_;
    const double diagonal = elementary::hypot(c.a, c.b);
    const bool both = diagonals_ == Diagonals::both;
    for (std::int32_t j = 0; j <= grid_.cells_y; ++j)
      for (std::int32_t i = 0; i <= grid_.cells_x; ++i) {
        const double share_x = j == 0 || j == grid_.cells_y ? c.border_share : 1.0;
        const double share_y = i == 0 || i == grid_.cells_x ? c.border_share : 1.0;
        const bool right = i < grid_.cells_x, up = j < grid_.cells_y;
        if (right) add_spring(index(i, j), index(i + 1, j), c.a, share_x * c.spring_x);
        if (up) add_spring(index(i, j), index(i, j + 1), c.b, share_y * c.spring_y);
        if (!right || !up) continue;
        if (both || rises(i, j))
          add_spring(index(i, j), index(i + 1, j + 1), diagonal, c.spring_diagonal);
        if (both || !rises(i, j))
          add_spring(index(i + 1, j), index(i, j + 1), diagonal, c.spring_diagonal);
      }
  }

  GridConfig grid_;
  Material material_;
  CellConstants constants_;
  Diagonals diagonals_;
  ClothMesh cloth_;
};

/// Stiffness of hinges on edges along x, along y, diagonal; N·m.
struct HingeConstants {
  double x, y, diagonal;
};

// If the cloth is bent to curvature κ along n = (c,s), an edge along x rotates by κ s² b, an edge
// along y by κ c² a, and a diagonal by κ c s l. With these stiffnesses the energy per area is ½ B
// κ² (s⁴ + c⁴ + 2 s²c²) = ½ B κ² in every direction, like a plate with Poisson's ratio 0. If warp
// and weft differ it is ½ κ² (√B_warp c² + √B_weft s²)² [Peirce1930]. An edge along x, the warp,
// rotates when the weft bends.
HingeConstants hinge_constants(const GridConfig& grid, const Material& m) {
  const CellConstants c = cell_sides(grid);
  const double l_squared = c.a * c.a + c.b * c.b, ratio = c.a / c.b;
  const double warp = m.bending_stiffness, weft = bending_along_weft(m);
  return {weft * ratio, warp / ratio, 2.0 * std::sqrt(warp * weft) * c.a * c.b / l_squared};
}

}  // namespace

CellConstants cell_sides(const GridConfig& grid) {
  CellConstants c;
  c.a = grid.size_x / grid.cells_x;
  c.b = grid.size_y / grid.cells_y;
  return c;
}

// C11 C22 - g² = warp C22 = weft C11, so that C11² - warp C11 - g² warp/weft = 0.
StretchConstants stretch_constants(double warp, double weft, double g) {
  const double c11 = 0.5 * (warp + std::sqrt(warp * warp + 4.0 * g * g * warp / weft));
  return {c11, c11 * weft / warp};
}

void validate_cells(const CellConstants& c, const Material& m) {
  if (c.spring_x > 0.0 && c.spring_y > 0.0) return;
  std::ostringstream text;
  text << "shear_stiffness " << m.shear_stiffness << " needs cells nearer to squares than " << c.a
       << " m by " << c.b << " m: the diagonals alone are stiffer than stretch_stiffness "
       << m.stretch_stiffness << "; change cells_x or cells_y";
  throw std::invalid_argument(text.str());
}

ClothMesh make_grid_net(const GridConfig& grid, const Material& material, const CellConstants& c,
                        Diagonals diagonals) {
  return GridNet(grid, material, c, diagonals).build();
}

// With the hinges of one triangulation, only every other vertex would resist curvature along x (the
// opposite vertices of an edge lie at one of its ends), and bent cloth would relax in a zigzag to
// two thirds of its stiffness. So an edge has two hinges of half the stiffness, one at each end.
// They are the second differences of every row and column, as in a finite-difference plate, and a
// border row represents half a cell. The twist of a cell, w00 + w11 - w10 - w01, is the same along
// both diagonals.
void add_grid_hinges(ClothMesh& cloth, const GridConfig& grid, const Material& material,
                     GridHinges wanted) {
  if (material.bending_stiffness <= 0.0) return;
  const bool sides = wanted == GridHinges::all;
  const HingeConstants k = hinge_constants(grid, material);
  const auto index = [&](std::int32_t i, std::int32_t j) { return vertex(grid, i, j); };
  const bool by_sine = bending_law_of(material).by_sine;
  const auto add = [&](const std::array<std::int32_t, 4>& v, double stiffness) {
    cloth.hinges.push_back({v, 0.0, stiffness, material.bending_damping, by_sine});
  };
  for (std::int32_t j = 0; j <= grid.cells_y; ++j)
    for (std::int32_t i = 0; i <= grid.cells_x; ++i) {
      if (sides && j > 0 && j < grid.cells_y && i < grid.cells_x)
        for (const std::int32_t end : {i, i + 1})
          add({index(end, j + 1), index(end, j - 1), index(i, j), index(i + 1, j)}, 0.5 * k.x);
      if (sides && i > 0 && i < grid.cells_x && j < grid.cells_y)
        for (const std::int32_t end : {j, j + 1})
          add({index(i - 1, end), index(i + 1, end), index(i, j), index(i, j + 1)}, 0.5 * k.y);
      if (i == grid.cells_x || j == grid.cells_y) continue;
      const std::int32_t v00 = index(i, j), v10 = index(i + 1, j);
      const std::int32_t v01 = index(i, j + 1), v11 = index(i + 1, j + 1);
      if ((i + j) % 2 == 0)
        add({v01, v10, v00, v11}, k.diagonal);
      else
        add({v00, v11, v10, v01}, k.diagonal);
    }
}

}  // namespace selvedge::detail
