// SPDX-License-Identifier: MIT
//
// Rectangular spring mesh after X. Provot, "Deformation constraints in a mass-spring model to
// describe rigid cloth behavior", Graphics Interface 1995. Deviations: hinges resist bending (a
// Hooke spring across two cells has no stiffness at zero curvature and adds to the stretch
// stiffness), and the stiffnesses come from fabric constants. make_spring_net builds the mesh of
// the paper.
//
// Cells a × b, structural springs kx (length a) and ky (length b), diagonals kd (length l) in every
// cell. The energy of a uniform strain per area gives
//   C11 = kx a/b + G a²/b²,  C22 = ky b/a + G b²/a²,  C12 = C33 = G = 2 kd a b/l²,
// that is, C11 = ks + kd and C12 = C33 = kd for square cells. The stretch stiffness K is the result
// of a strip test with free sides, C11 - C12²/C22 = K along the warp and C22 - C12²/C11 = K' along
// the weft,
//   C11 = (K + sqrt(K² + 4 G² K/K'))/2,  C22 = C11 K'/K.
// The coupling of every spring net remains, C12 = C33: a strip stretched by ε narrows by ε G/C11.
// With shear by twisting springs there are no diagonals, C11 = K, C22 = K' and C12 = 0.
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/detail/grid_bending.h>
#include <selvedge/core/cloth/detail/grid_mesh.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/make_cloth.h>

namespace selvedge {
namespace {

detail::CellConstants cell_constants(const GridConfig& grid, const Material& m) {
  detail::CellConstants c = detail::cell_sides(grid);
  const double l_squared = c.a * c.a + c.b * c.b, ratio = c.a / c.b;
  const double g = shear_law_of(m).by_springs ? m.shear_stiffness : 0.0;
  const auto [c11, c22] = detail::stretch_constants(m.stretch_stiffness, stretch_along_weft(m), g);
  c.spring_x = (c11 - g * ratio * ratio) / ratio;
  c.spring_y = (c22 - g / (ratio * ratio)) * ratio;
  c.spring_diagonal = g * l_squared / (2.0 * c.a * c.b);
  return c;
}

}  // namespace

ClothMesh make_rectangular(const GridConfig& grid, const Material& material) {
  detail::validate_grid(grid);
  detail::validate_material(material);
  const detail::CellConstants constants = cell_constants(grid, material);
  detail::validate_cells(constants, material);
  ClothMesh cloth = detail::make_grid_net(grid, material, constants, detail::Diagonals::both);
  detail::add_grid_bending(cloth, grid, material);
  const ShearLaw& shear = shear_law_of(material);
  if (shear.add_to_grid != nullptr && material.shear_stiffness > 0.0)
    shear.add_to_grid(cloth, grid, material);
  detail::set_stretch_law(cloth, cloth.surface.vertices, material);
  return cloth;
}

void register_rectangular(ClothPatternRegistry& registry) {
  registry.add("rectangular", {},
               [](const MethodOptions&, const GridConfig& grid, const Material& material) {
                 return make_rectangular(grid, material);
               },
               {.promise = "warp, weft and both diagonals are springs; hinges bend",
                .source = "Provot, Deformation constraints in a mass-spring model, 1995",
                .splits = true});
}

}  // namespace selvedge
