// SPDX-License-Identifier: MIT
//
// Simplified mesh: the rectangular mesh with one of the two diagonals of each cell. W. Huang et
// al., "Cloth simulation based on simplified mass-spring model", 2014; J. Hu et al., 2013 (survey
// section 2.7). 50 × 50 particles: 4900 structural and 2401 shear springs, with the flexion springs
// of the papers 12 101 (make_spring_net), 16.6 % fewer than the rectangular mesh.
//
// The survey calls the effect of the missing diagonal negligible. At equal constants it is not. If
// all diagonals are alike, C12 = C33 = G = kd a b/l² (half the value of two diagonals of kd), and
// stretch and shear are coupled, C13 = G a/b, C23 = G b/a, unlike in the rectangular mesh: freely
// hanging cloth swings to one side. `alternating` uses the other diagonal in every second cell.
// Every particle is then a centre of symmetry, so the mesh deforms affinely under uniform strain,
// and C13 = C23 = 0.
//
// Fabric: kd = G l²/(a b). With alternating diagonals the other constants are those of the
// rectangular mesh. With equal diagonals the modulus of a strip that may shear freely, 1/(C⁻¹)11,
// is exactly kx a/b, so kx = K b/a and ky = K a/b.
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/detail/grid_bending.h>
#include <selvedge/core/cloth/detail/grid_mesh.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <stdexcept>

namespace selvedge {
namespace {

detail::CellConstants cell_constants(const GridConfig& grid, const Material& m, bool alternating) {
  detail::CellConstants c = detail::cell_sides(grid);
  const double l_squared = c.a * c.a + c.b * c.b, ratio = c.a / c.b;
  const double warp = m.stretch_stiffness, weft = stretch_along_weft(m);
  const double g = shear_law_of(m).by_springs ? m.shear_stiffness : 0.0;
  const auto [c11, c22] = detail::stretch_constants(warp, weft, g);
  c.spring_x = alternating ? (c11 - g * ratio * ratio) / ratio : warp / ratio;
  c.spring_y = alternating ? (c22 - g / (ratio * ratio)) * ratio : weft * ratio;
  c.spring_diagonal = g * l_squared / (c.a * c.b);
  return c;
}

}  // namespace

ClothMesh make_simplified(const GridConfig& grid, const Material& material, bool alternating) {
  detail::validate_grid(grid);
  detail::validate_material(material);
  if (shear_law_of(material).add_to_grid != nullptr)
    throw std::invalid_argument(
        "shear_law \"" + material.shear_law +
        "\" needs a mesh without diagonals; the simplified mesh has one, use "
        "the rectangular pattern");
  const detail::CellConstants constants = cell_constants(grid, material, alternating);
  detail::validate_cells(constants, material);
  ClothMesh cloth =
      detail::make_grid_net(grid, material, constants,
                            alternating ? detail::Diagonals::alternating : detail::Diagonals::same);
  detail::add_grid_bending(cloth, grid, material);
  detail::set_stretch_law(cloth, cloth.surface.vertices, material);
  return cloth;
}

void register_simplified(ClothPatternRegistry& registry) {
  registry.add(
      "simplified", {},
      [](const MethodOptions&, const GridConfig& grid, const Material& material) {
        return make_simplified(grid, material, false);
      },
      {.promise = "one diagonal: couples stretch and shear",
       .source = "Huang et al., Cloth simulation based on simplified mass-spring model, 2014"});
  registry.add("checkerboard", {},
               [](const MethodOptions&, const GridConfig& grid, const Material& material) {
                 return make_simplified(grid, material, true);
               },
               {.promise = "one diagonal, the other one in every second cell: no coupling",
                .source = "Huang et al., 2014, corrected"});
}

}  // namespace selvedge
