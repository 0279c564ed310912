// SPDX-License-Identifier: MIT
//
// Bilayered mesh after Y.-M. Kang, H.-G. Cho, "Bilayered approximate integration for rapid and
// plausible animation of virtual cloth with realistic wrinkles", Computer Animation 2002 (survey
// section 2.4). The sparse mesh has internal and external forces and is the one that is solved. The
// dense mesh, which is drawn, has internal forces alone: each step carries it along with the
// interpolated sparse mesh and relaxes it by one local iteration (following.cpp). Deviations: the
// dense mesh keeps its distance d from the interpolated one from step to step, so that wrinkles can
// grow, and springs of `hold` N/m³ draw it back; it collides, and its contacts move the sparse
// mesh. It has the fraction `share` of the stiffness and, for its contacts and its local iteration,
// of the mass; in the solve the sparse mesh has the whole mass. Its wrinkles are those of a sheet
// of rigidity share·B on a foundation of stiffness `hold`: they look like wrinkles but are not
// those of the fabric.
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace selvedge {
namespace {

void validate_layers(const GridConfig& grid, const LayerConfig& layers) {
  require(layers.share > 0.0 && layers.share < 1.0, "share", layers.share, "between 0 and 1");
  require(std::isfinite(layers.hold) && layers.hold > 0.0, "hold", layers.hold,
          "positive and finite");
  require(layers.ratio >= 2, "ratio", layers.ratio, "at least 2");
  for (const std::int32_t cells : {grid.cells_x, grid.cells_y})
    if (cells % layers.ratio != 0)
      throw std::invalid_argument("cells of a bilayered mesh must be multiples of the ratio " +
                                  std::to_string(layers.ratio) + ", not " + std::to_string(cells));
}

/// The fabric of the dense layer. Loops are those of the sparse one.
Material part_of(Material m, double share) {
  m.density *= share;
  m.stretch_stiffness *= share;
  m.shear_stiffness *= share;
  m.bending_stiffness *= share;
  if (m.stretch_weft) *m.stretch_weft *= share;
  if (m.bending_weft) *m.bending_weft *= share;
  m.shear_friction = 0.0;
  m.bending_friction = 0.0;
  return m;
}

/// The four corners of the sparse cell that contains node k of a dense row or column, in one
/// direction: index of the lower line and weight of the upper one.
struct Place {
  std::int32_t line;
  double weight;
};

Place place_of(std::int32_t k, std::int32_t ratio, std::int32_t sparse_cells) {
  const std::int32_t line = std::min(k / ratio, sparse_cells - 1);
  return {line, static_cast<double>(k - line * ratio) / ratio};
}

}  // namespace

ClothMesh make_bilayered(const GridConfig& grid, const LayerConfig& layers,
                         const Material& material) {
  detail::validate_grid(grid);
  validate_layers(grid, layers);
  GridConfig coarse = grid;
  coarse.cells_x /= layers.ratio;
  coarse.cells_y /= layers.ratio;
  ClothMesh cloth = make_rectangular(grid, part_of(material, layers.share));
  Material carrying = material;
  carrying.density *= 1.0 - layers.share;
  ClothMesh sparse = make_rectangular(coarse, carrying);
  // The sparse layer has no surface; at the start it coincides with the dense layer bit for bit.
  sparse.surface.triangles.clear();
  sparse.edges.clear();
  const std::int32_t up = grid.cells_x + 1, up_sparse = coarse.cells_x + 1;
  for (std::int32_t j = 0; j <= coarse.cells_y; ++j)
    for (std::int32_t i = 0; i <= coarse.cells_x; ++i)
      sparse.surface.vertices[j * up_sparse + i] =
          cloth.surface.vertices[j * layers.ratio * up + i * layers.ratio];
  const double density = material.density * layers.share;
  const std::int32_t first = append(cloth, sparse);
  for (std::int32_t j = 0; j <= grid.cells_y; ++j)
    for (std::int32_t i = 0; i <= grid.cells_x; ++i) {
      const Place x = place_of(i, layers.ratio, coarse.cells_x);
      const Place y = place_of(j, layers.ratio, coarse.cells_y);
      const std::int32_t dense = j * up + i, corner = first + y.line * up_sparse + x.line;
      const double area = cloth.mass[dense] / density;
      cloth.layers.push_back(
          {{dense, corner, corner + 1, corner + up_sparse, corner + up_sparse + 1},
           {(1.0 - x.weight) * (1.0 - y.weight), x.weight * (1.0 - y.weight),
            (1.0 - x.weight) * y.weight, x.weight * y.weight},
           layers.hold * area,
           material.spring_damping});
    }
  return cloth;
}

void register_bilayered(ClothPatternRegistry& registry) {
  const LayerConfig layers{};
  registry.add(
      "bilayered",
      {{.name = "ratio",
        .initial = static_cast<double>(layers.ratio),
        .unit = "1",
        .least = 2.0,
        .most = 100.0,
        .kind = OptionKind::whole,
        .meaning = "cells of the dense layer per cell of the sparse one along each side"},
       {.name = "share",
        .initial = layers.share,
        .unit = "1",
        .least = 0.0,
        .most = 0.99,
        .above_least = true,
        .meaning = "fraction of mass and stiffness of the dense layer"},
       {.name = "hold",
        .initial = layers.hold,
        .unit = "N/m³",
        .least = 0.0,
        .most = 1e9,
        .above_least = true,
        .meaning = "force per area and distance with which the dense layer returns to the "
                   "sparse one; less makes longer wrinkles"}},
      [](const MethodOptions& o, const GridConfig& grid, const Material& material) {
        return make_bilayered(grid, {o.whole("ratio"), o["share"], o["hold"]}, material);
      },
      {.promise = "a dense layer that collides and wrinkles on a sparse one that is solved",
       .source = "Kang, Cho, Bilayered approximate integration, 2002",
       .two_layers = true});
}

}  // namespace selvedge
