// SPDX-License-Identifier: MIT
//
// Rectangular spring mesh after X. Provot, "Deformation constraints in a mass-spring model to
// describe rigid cloth behavior", Graphics Interface 1995. Deviations: bending is by hinges (a
// Hooke spring over two cells has no stiffness at zero curvature and adds to the stretch), and the
// stiffnesses come from fabric constants.
//
// Cells a × b, structural springs kx (length a) and ky (length b), diagonals kd (length l) in every
// cell. The energy of a uniform strain per area gives
//   C11 = kx a/b + G a²/b²,  C22 = ky b/a + G b²/a²,  C12 = C33 = G = 2 kd a b/l²,
// that is C11 = ks + kd, C12 = C33 = kd for square cells. The stretch stiffness K is what a strip
// test with free sides measures, C11 - C12²/C22 = C22 - C12²/C11 = K, so
//   C11 = C22 = (K + sqrt(K² + 4 G²))/2.
// What remains is the coupling every spring net has, C12 = C33: a strip stretched by ε narrows by
// ε G/C11.
#include <selvedge/core/cloth_mesh.h>
#include <selvedge/core/detail/topology.h>

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace selvedge {
namespace {

/// Stiffnesses of the inner springs and of the hinges of a rectangular mesh.
struct CellConstants {
  double a, b;                                 // m, sides of a cell
  double spring_x, spring_y, spring_diagonal;  // N/m
  double hinge_x, hinge_y, hinge_diagonal;     // N·m, on edges along x, along y, diagonal
};

CellConstants cell_constants(const GridConfig& grid, const Material& m) {
  CellConstants c{};
  c.a = grid.size_x / grid.cells_x;
  c.b = grid.size_y / grid.cells_y;
  const double l_squared = c.a * c.a + c.b * c.b, ratio = c.a / c.b;
  const double k = m.stretch_stiffness, g = m.shear_stiffness;
  const double c11 = 0.5 * (k + std::sqrt(k * k + 4.0 * g * g));
  c.spring_x = (c11 - g * ratio * ratio) / ratio;
  c.spring_y = (c11 - g / (ratio * ratio)) * ratio;
  c.spring_diagonal = g * l_squared / (2.0 * c.a * c.b);
  // Bent to curvature κ across n = (c,s), an edge along x turns by κ s² b, along y by κ c² a, and a
  // diagonal by κ c s l. With these stiffnesses the energy per area is
  // ½ B κ² (s⁴ + c⁴ + 2 s²c²) = ½ B κ² in every direction: that of a plate with Poisson's ratio 0.
  c.hinge_x = m.bending_stiffness * ratio;
  c.hinge_y = m.bending_stiffness / ratio;
  c.hinge_diagonal = 2.0 * m.bending_stiffness * c.a * c.b / l_squared;
  return c;
}

void validate_constants(const CellConstants& c, const Material& m) {
  if (c.spring_x > 0.0 && c.spring_y > 0.0) return;
  std::ostringstream text;
  text << "shear_stiffness " << m.shear_stiffness << " needs cells nearer to squares than " << c.a
       << " m by " << c.b << " m: the diagonals alone are stiffer than stretch_stiffness "
       << m.stretch_stiffness << "; change cells_x or cells_y";
  throw std::invalid_argument(text.str());
}

class RectangularMesh {
 public:
  RectangularMesh(const GridConfig& grid, const Material& material)
      : grid_(grid), material_(material), constants_(cell_constants(grid, material)) {
    validate_constants(constants_, material);
  }

  ClothMesh build() {
    add_vertices();
    add_triangles();
    add_springs();
    add_hinges();
    return std::move(cloth_);
  }

 private:
  std::int32_t index(std::int32_t i, std::int32_t j) const { return j * (grid_.cells_x + 1) + i; }

  void add_vertices() {
    // A vertex owns a quarter of each cell around it.
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
        if ((i + j) % 2 == 0) {
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
    const double diagonal = std::hypot(c.a, c.b);
    for (std::int32_t j = 0; j <= grid_.cells_y; ++j)
      for (std::int32_t i = 0; i <= grid_.cells_x; ++i) {
        // A spring on the border stands for half a cell.
        const double share_x = j == 0 || j == grid_.cells_y ? 0.5 : 1.0;
        const double share_y = i == 0 || i == grid_.cells_x ? 0.5 : 1.0;
        const bool right = i < grid_.cells_x, up = j < grid_.cells_y;
        if (right) add_spring(index(i, j), index(i + 1, j), c.a, share_x * c.spring_x);
        if (up) add_spring(index(i, j), index(i, j + 1), c.b, share_y * c.spring_y);
        if (!right || !up) continue;
        add_spring(index(i, j), index(i + 1, j + 1), diagonal, c.spring_diagonal);
        add_spring(index(i + 1, j), index(i, j + 1), diagonal, c.spring_diagonal);
      }
  }

  void add_hinge(const std::array<std::int32_t, 4>& v, double stiffness) {
    cloth_.hinges.push_back({v, 0.0, stiffness, material_.bending_damping});
  }

  // The hinges of one triangulation would feel the curvature along x in every other vertex only
  // (the opposite vertices of an edge lie at one of its ends), and a bent cloth would relax by a
  // zigzag to two thirds of its stiffness. So an edge has two hinges, one for each of its ends,
  // with half the stiffness each: the second differences of every row and column, as in the
  // finite-difference plate. A border row thereby stands for half a cell.
  void add_hinges() {
    if (material_.bending_stiffness <= 0.0) return;
    for (std::int32_t j = 0; j <= grid_.cells_y; ++j)
      for (std::int32_t i = 0; i <= grid_.cells_x; ++i) {
        if (j > 0 && j < grid_.cells_y && i < grid_.cells_x)
          for (const std::int32_t end : {i, i + 1})
            add_hinge({index(end, j + 1), index(end, j - 1), index(i, j), index(i + 1, j)},
                      0.5 * constants_.hinge_x);
        if (i > 0 && i < grid_.cells_x && j < grid_.cells_y)
          for (const std::int32_t end : {j, j + 1})
            add_hinge({index(i - 1, end), index(i + 1, end), index(i, j), index(i, j + 1)},
                      0.5 * constants_.hinge_y);
        if (i < grid_.cells_x && j < grid_.cells_y) add_diagonal_hinge(i, j);
      }
  }

  void add_diagonal_hinge(std::int32_t i, std::int32_t j) {
    const std::int32_t v00 = index(i, j), v10 = index(i + 1, j);
    const std::int32_t v01 = index(i, j + 1), v11 = index(i + 1, j + 1);
    if ((i + j) % 2 == 0)
      add_hinge({v01, v10, v00, v11}, constants_.hinge_diagonal);
    else
      add_hinge({v00, v11, v10, v01}, constants_.hinge_diagonal);
  }

  GridConfig grid_;
  Material material_;
  CellConstants constants_;
  ClothMesh cloth_;
};

}  // namespace

ClothMesh make_rectangular(const GridConfig& grid, const Material& material) {
  detail::validate_grid(grid);
  detail::validate_material(material);
  return RectangularMesh(grid, material).build();
}

}  // namespace selvedge
