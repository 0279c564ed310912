// SPDX-License-Identifier: MIT
//
// K.-J. Choi, H.-S. Ko, "Stable but responsive cloth", SIGGRAPH 2002 (survey section 2.3, which
// presents it only as a mesh; its novelty is the two kinds of links). Type 1 joins structural and
// diagonal neighbours and resists tension only. Type 2 joins every other particle along rows,
// columns and both diagonals, and buckles (make_buckling_force). 50 × 50 particles: 9702 of type 1
// and 9408 of type 2, 19 110 springs, 31.8 % more than the rectangular mesh; fewer if material
// constants make some of them vanish.
//
// Fabric: type 1 as in the rectangular mesh, so that under tension C11 = C22 and C12 = C33 = G;
// type 2 from the plate rigidity B as in add_grid_bending. Under compression only the type 2 links
// have stiffness. Deviation: the paper uses one constant for all type 2 links; here the four
// directions are weighted so that B is the same in each.
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <stdexcept>
#include <string>

namespace selvedge {

// A material says nothing about its bending by the default law: the reader of scenes completes
// defaults.
ClothMesh make_responsive(const GridConfig& grid, const Material& material) {
  Material m = material;
  if (m.bending_law != Material{}.bending_law && m.bending_law != "buckling")
    throw std::invalid_argument(
        std::string("the responsive mesh bends by links that buckle, so bending_law \"") +
        m.bending_law +
        "\" has no effect on it; leave it out, or use the rectangular pattern with stretch_law "
        "\"tension_only\"");
  m.bending_law = "buckling";
  if (stretch_law_of(m).add_to_triangles != nullptr)
    throw std::invalid_argument(
        "the responsive mesh resists tension only, which no finite element does; use stretch_law "
        "\"tension_only\", or the rectangular pattern");
  if (m.stretch_law == "hooke") m.stretch_law = "tension_only";
  return make_rectangular(grid, m);
}

void register_responsive(ClothPatternRegistry& registry) {
  registry.add("responsive", {},
               [](const MethodOptions&, const GridConfig& grid, const Material& material) {
                 return make_responsive(grid, material);
               },
               {.promise = "resists tension only; links over two cells buckle",
                .source = "Choi, Ko, Stable but responsive cloth, 2002"});
}

}  // namespace selvedge
