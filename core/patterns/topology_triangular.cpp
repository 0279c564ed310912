// SPDX-License-Identifier: MIT
//
// Rows of triangles with straight borders; every other row is shifted by half a cell. The triangles
// are equilateral if size_y/cells_y is sqrt(3)/2 of size_x/cells_x. Edge stiffnesses after A. Van
// Gelder, "Approximate simulation of elastic membranes by triangulated spring meshes", Journal of
// Graphics Tools 1998.
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <algorithm>

namespace selvedge {
namespace {

/// Number of vertices in row j: cells + 1 on the grid, cells + 2 if the row is shifted.
std::int32_t row_size(const GridConfig& grid, std::int32_t j) { return grid.cells_x + 1 + j % 2; }

void add_row(const GridConfig& grid, std::int32_t j, std::vector<Vec3>& vertices) {
  const double a = grid.size_x / grid.cells_x;
  const double y = grid.size_y * j / grid.cells_y - 0.5 * grid.size_y;
  for (std::int32_t i = 0; i < row_size(grid, j); ++i) {
    const double x = j % 2 == 0 ? i * a : std::clamp((i - 0.5) * a, 0.0, grid.size_x);
    vertices.emplace_back(x - 0.5 * grid.size_x, y, 0.0);
  }
}

/// Triangles between the row that starts at `below` and the next one at `above`.
void add_strip(std::int32_t cells, bool below_is_shifted, std::int32_t below, std::int32_t above,
               std::vector<Triangle>& triangles) {
  for (std::int32_t i = 0; i <= cells; ++i) {
    if (below_is_shifted) {
      triangles.push_back({below + i, below + i + 1, above + i});
      if (i < cells) triangles.push_back({below + i + 1, above + i + 1, above + i});
    } else {
      triangles.push_back({below + i, above + i + 1, above + i});
      if (i < cells) triangles.push_back({below + i, below + i + 1, above + i + 1});
    }
  }
}

}  // namespace

ClothMesh make_triangular(const GridConfig& grid, const Material& material) {
  detail::validate_grid(grid);
  detail::validate_material(material);
  TriangleMesh mesh;
  std::int32_t below = 0;
  for (std::int32_t j = 0; j <= grid.cells_y; ++j) {
    add_row(grid, j, mesh.vertices);
    if (j == grid.cells_y) break;
    const std::int32_t above = below + row_size(grid, j);
    add_strip(grid.cells_x, j % 2 == 1, below, above, mesh.triangles);
    below = above;
  }
  return make_from_mesh(mesh, mesh, material);
}

void register_triangular(ClothPatternRegistry& registry) {
  registry.add("triangular", {},
               [](const MethodOptions&, const GridConfig& grid, const Material& material) {
                 return make_triangular(grid, material);
               },
               {.promise = "the edges of nearly equilateral triangles are springs; hinges bend",
                .source = "Van Gelder, Approximate simulation of elastic membranes, 1998",
                .splits = true,
                .fits_plate = true});
}

}  // namespace selvedge
