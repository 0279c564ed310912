// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/adaptive_triangles.h>
#include <selvedge/core/cloth_pattern.h>

#include <span>
#include <utility>
#include <variant>
#include <vector>

namespace selvedge {

/// Cloth whose cells are split as it moves: those of a grid, or triangles. A triangle is the cell
/// {0, number, 0}.
class AdaptiveCloth {
 public:
  AdaptiveCloth(AdaptiveGrid grid) : cells_(std::move(grid)) {}                 // NOLINT: implicit
  AdaptiveCloth(AdaptiveTriangles triangles) : cells_(std::move(triangles)) {}  // NOLINT: implicit

  std::int32_t vertex_count() const;
  const Edge& parents(std::int32_t i) const;
  ClothMesh cloth() const;
  /// As those of AdaptiveGrid and AdaptiveTriangles.
  std::vector<GridCell> curved(std::span<const Vec3> x, double angle) const;
  std::vector<GridCell> divisible() const;
  void split(std::span<const GridCell> cells, std::vector<Vec3>& x, std::vector<Vec3>& v);

  /// The grid, whose cells can also be joined; null for triangles.
  const AdaptiveGrid* grid() const { return std::get_if<AdaptiveGrid>(&cells_); }
  AdaptiveGrid* grid() { return std::get_if<AdaptiveGrid>(&cells_); }

 private:
  std::variant<AdaptiveGrid, AdaptiveTriangles> cells_;
};

}  // namespace selvedge
