// SPDX-License-Identifier: MIT
//
// The grid meshes as their authors print them, for comparisons: X. Provot 1995 (rectangular),
// W. Huang et al. 2014 (simplified), K.-J. Choi and H.-S. Ko 2002 (responsive; here with Hooke
// springs for its type 2). Springs of N × N particles: structural 2N(N-1), shear 2(N-1)² or half of
// that, flexion 2N(N-2), and 2(N-2)² more along the diagonals in the responsive mesh. For N = 50:
// 14 502, 12 101 and 19 110; the survey's order of run times "triangular < simplified <
// rectangular" does not follow from counts, as the triangular mesh has 7301 edges and 7105 links.
//
// Square cells: C11 = C22 = ks + kd + 4 kb, C12 = C33 = kd with two diagonals, C12 = C33 = C13 =
// C23 = kd/2 with one. Hooke springs across two cells have no stiffness at zero curvature (energy ∝
// κ⁴) and add 4 kb to the stretch stiffness, so these meshes cannot converge to a plate.
#include <selvedge/core/cloth_mesh.h>
#include <selvedge/core/detail/grid_mesh.h>
#include <selvedge/core/detail/topology.h>

#include <cmath>

namespace selvedge {
namespace {

void validate_constants(const NetConstants& c) {
  const auto number = [](const char* name, double value) {
    require(std::isfinite(value) && value >= 0.0, name, value, "at least 0 and finite");
  };
  number("structural", c.structural);
  number("shear", c.shear);
  number("flexion", c.flexion);
}

class FlexionSprings {
 public:
  FlexionSprings(ClothMesh& cloth, const GridConfig& grid, const NetConstants& constants,
                 const Material& material)
      : cloth_(cloth), grid_(grid), constants_(constants), material_(material) {}

  void add(bool diagonals) {
    if (constants_.flexion <= 0.0) return;
    const std::int32_t nx = grid_.cells_x, ny = grid_.cells_y, up = nx + 1;
    for (std::int32_t j = 0; j <= ny; ++j)
      for (std::int32_t i = 0; i <= nx; ++i) {
        const std::int32_t p = j * up + i;
        const bool right = i + 2 <= nx, above = j + 2 <= ny, below = j >= 2;
        if (right) add_spring(p, p + 2, share(j, ny));
        if (above) add_spring(p, p + 2 * up, share(i, nx));
        if (!diagonals || !right) continue;
        if (above) add_spring(p, p + 2 * up + 2, 1.0);
        if (below) add_spring(p, p - 2 * up + 2, 1.0);
      }
  }

 private:
  double share(std::int32_t line, std::int32_t last) const {
    return constants_.half_border && (line == 0 || line == last) ? 0.5 : 1.0;
  }

  void add_spring(std::int32_t a, std::int32_t b, double share) {
    const std::vector<Vec3>& x = cloth_.surface.vertices;
    cloth_.springs.push_back(
        {a, b, (x[b] - x[a]).norm(), share * constants_.flexion, material_.spring_damping});
    cloth_.strain_limit.push_back(material_.strain_limit);
  }

  ClothMesh& cloth_;
  const GridConfig& grid_;
  const NetConstants& constants_;
  const Material& material_;
};

detail::Diagonals diagonals_of(SpringNet net) {
  if (net == SpringNet::simplified) return detail::Diagonals::same;
  if (net == SpringNet::alternating) return detail::Diagonals::alternating;
  return detail::Diagonals::both;
}

}  // namespace

ClothMesh make_spring_net(SpringNet net, const GridConfig& grid, const NetConstants& constants,
                          const Material& material) {
  detail::validate_grid(grid);
  detail::validate_material(material);
  validate_constants(constants);
  detail::CellConstants c = detail::cell_sides(grid);
  c.spring_x = c.spring_y = constants.structural;
  c.spring_diagonal = constants.shear;
  if (!constants.half_border) c.border_share = 1.0;
  ClothMesh cloth = detail::make_grid_net(grid, material, c, diagonals_of(net));
  FlexionSprings(cloth, grid, constants, material).add(net == SpringNet::responsive);
  return cloth;
}

}  // namespace selvedge
