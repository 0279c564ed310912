// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/internal/adaptive_triangles.h>

#include <span>
#include <utility>
#include <variant>
#include <vector>

namespace selvedge {

/// Cloth whose cells are split and joined as it moves: the cells of a grid, or triangles. For
/// triangles, the cell {0, number, 0} names the triangle to split, and {0, vertex, 0} the vertex
/// whose bisection is undone.
class AdaptiveCloth {
 public:
  AdaptiveCloth(AdaptiveGrid grid) : cells_(std::move(grid)) {}                 // NOLINT: implicit
  AdaptiveCloth(AdaptiveTriangles triangles) : cells_(std::move(triangles)) {}  // NOLINT: implicit

  std::int32_t vertex_count() const;
  const Edge& parents(std::int32_t i) const;
  ClothMesh cloth() const;
  /// The rest shape of cloth(); triangle i is that of its surface.
  TriangleMesh rest() const;
  /// These functions work like those of AdaptiveGrid and AdaptiveTriangles.
  std::vector<GridCell> curved(std::span<const Vec3> x, double angle) const;
  std::vector<GridCell> divisible() const;
  void split(std::span<const GridCell> cells, std::vector<Vec3>& x, std::vector<Vec3>& v);

  std::vector<GridCell> flat(std::span<const Vec3> x, double angle, double limit) const;
  std::vector<Vec3> flattened(std::span<const GridCell> cells, std::span<const Vec3> x) const;
  std::vector<std::int32_t> join(std::span<const GridCell> cells, std::vector<Vec3>& x,
                                 std::vector<Vec3>& v);
  std::vector<std::int32_t> nodes(const GridCell& cell) const;

 private:
  const AdaptiveGrid* grid() const { return std::get_if<AdaptiveGrid>(&cells_); }
  AdaptiveGrid* grid() { return std::get_if<AdaptiveGrid>(&cells_); }

  std::variant<AdaptiveGrid, AdaptiveTriangles> cells_;
};

}  // namespace selvedge
