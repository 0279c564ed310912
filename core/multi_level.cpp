// SPDX-License-Identifier: MIT
//
// Multi-level meshes after D. Zhang, M. Yuen, "Cloth simulation using multilevel meshes", Computers
// & Graphics 2001 (survey section 2.2): a coarse mesh falls first, finer ones take over. The survey
// gives no rule for when; here it is the largest speed. Masses of a grid are a quarter of each
// cell, so that Σ m v is the integral of the bilinear velocity, which halving the cells does not
// change.
#include <selvedge/core/detail/topology.h>
#include <selvedge/core/multi_level.h>

#include <algorithm>
#include <string>

namespace selvedge {
namespace {

void require_size(const char* what, std::size_t is, std::size_t should) {
  if (is == should) return;
  throw std::invalid_argument(std::string("refine: ") + std::to_string(is) + " " + what + " for " +
                              std::to_string(should) + " vertices of the grid");
}

/// Values at the vertices, at the middles of edges and of cells.
std::vector<Vec3> interpolate(const GridConfig& coarse, const std::vector<Vec3>& u) {
  const std::int32_t nx = coarse.cells_x, ny = coarse.cells_y;
  std::vector<Vec3> fine;
  fine.reserve(static_cast<std::size_t>(2 * nx + 1) * (2 * ny + 1));
  for (std::int32_t j = 0; j <= 2 * ny; ++j)
    for (std::int32_t i = 0; i <= 2 * nx; ++i) {
      const auto at = [&](std::int32_t di, std::int32_t dj) -> const Vec3& {
        return u[static_cast<std::size_t>(j / 2 + dj) * (nx + 1) + (i / 2 + di)];
      };
      // At a vertex of the coarse grid all four are the same one, and the value keeps its bits.
      const std::int32_t right = i % 2, up = j % 2;
      fine.push_back(0.25 * ((at(0, 0) + at(right, 0)) + (at(0, up) + at(right, up))));
    }
  return fine;
}

}  // namespace

LevelState refine(const LevelState& coarse) {
  detail::validate_grid(coarse.grid);
  const std::size_t n = static_cast<std::size_t>(coarse.grid.cells_x + 1) *
                        static_cast<std::size_t>(coarse.grid.cells_y + 1);
  require_size("positions", coarse.x.size(), n);
  require_size("velocities", coarse.v.size(), n);
  // Halved before it is validated, 2^30 cells and more would not fit an int32_t.
  detail::require(std::max(coarse.grid.cells_x, coarse.grid.cells_y) < (1 << 29), "cells to refine",
                  std::max(coarse.grid.cells_x, coarse.grid.cells_y), "below 2^29");
  LevelState fine{coarse.grid, {}, {}};
  fine.grid.cells_x *= 2;
  fine.grid.cells_y *= 2;
  detail::validate_grid(fine.grid);
  fine.x = interpolate(coarse.grid, coarse.x);
  fine.v = interpolate(coarse.grid, coarse.v);
  return fine;
}

bool has_settled(const LevelState& state, double speed) {
  return std::all_of(state.v.begin(), state.v.end(),
                     [&](const Vec3& v) { return v.norm() <= speed; });
}

}  // namespace selvedge
