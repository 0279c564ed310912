// SPDX-License-Identifier: MIT
// A net of warp and weft threads: springs along the sides of the cells, and nothing against shear.
#include "additions.h"

namespace adding {
namespace {

using namespace selvedge;

ClothMesh make_threads(const GridConfig& grid, const Material& material, double weft) {
  ClothMesh cloth;
  const std::int32_t columns = grid.cells_x + 1, rows = grid.cells_y + 1;
  const double dx = grid.size_x / grid.cells_x, dy = grid.size_y / grid.cells_y;
  for (std::int32_t j = 0; j < rows; ++j)
    for (std::int32_t i = 0; i < columns; ++i)
      cloth.surface.vertices.push_back({i * dx - grid.size_x / 2, j * dy - grid.size_y / 2, 0.0});
  for (std::int32_t j = 0; j < grid.cells_y; ++j)
    for (std::int32_t i = 0; i < grid.cells_x; ++i) {
      const std::int32_t a = j * columns + i, b = a + columns;
      cloth.surface.triangles.push_back({a, a + 1, b});
      cloth.surface.triangles.push_back({a + 1, b + 1, b});
    }
  cloth.edges = unique_edges(cloth.surface.triangles);
  for (const double area : vertex_areas(cloth.surface.vertices, cloth.surface.triangles))
    cloth.mass.push_back(material.density * area);

  // A warp thread has the stiffness of the strip of cloth that it stands for.
  const double warp = material.stretch_stiffness;  // N/m
  const auto add = [&](std::int32_t a, std::int32_t b, double length, double stiffness) {
    cloth.springs.push_back({a, b, length, stiffness / length, material.spring_damping});
    cloth.strain_limit.push_back(material.strain_limit);
  };
  for (std::int32_t j = 0; j < rows; ++j)
    for (std::int32_t i = 0; i < columns; ++i) {
      const std::int32_t v = j * columns + i;
      const bool border_x = i == 0 || i + 1 == columns, border_y = j == 0 || j + 1 == rows;
      if (i + 1 < columns) add(v, v + 1, dx, warp * (border_y ? dy / 2 : dy));
      if (j + 1 < rows) add(v, v + columns, dy, weft * warp * (border_x ? dx / 2 : dx));
    }
  return cloth;
}

}  // namespace

void register_threads(ClothPatternRegistry& registry) {
  registry.add("threads",
               {{.name = "weft",
                 .initial = 1.0,
                 .unit = "1",
                 .least = 0.0,
                 .above_least = true,
                 .meaning = "stiffness of a weft thread relative to a warp thread"}},
               [](const MethodOptions& o, const GridConfig& grid, const Material& material) {
                 return make_threads(grid, material, o["weft"]);
               },
               {.promise = "resists stretch along warp and weft only", .source = "docs/adding.md"});
}

}  // namespace adding
