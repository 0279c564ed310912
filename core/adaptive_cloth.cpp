// SPDX-License-Identifier: MIT
#include <selvedge/core/adaptive_cloth.h>

namespace selvedge {
namespace {

std::vector<GridCell> cells_of(const std::vector<std::int32_t>& triangles) {
  std::vector<GridCell> cells;
  for (const std::int32_t t : triangles) cells.push_back({0, t, 0});
  return cells;
}

}  // namespace

std::int32_t AdaptiveCloth::vertex_count() const {
  return std::visit([](const auto& cells) { return cells.vertex_count(); }, cells_);
}

const Edge& AdaptiveCloth::parents(std::int32_t i) const {
  return std::visit([&](const auto& cells) -> const Edge& { return cells.parents(i); }, cells_);
}

ClothMesh AdaptiveCloth::cloth() const {
  return std::visit([](const auto& cells) { return cells.cloth(); }, cells_);
}

std::vector<GridCell> AdaptiveCloth::curved(std::span<const Vec3> x, double angle) const {
  if (grid() != nullptr) return grid()->curved(x, angle);
  return cells_of(std::get<AdaptiveTriangles>(cells_).curved(x, angle));
}

std::vector<GridCell> AdaptiveCloth::divisible() const {
  if (grid() != nullptr) return grid()->divisible();
  return cells_of(std::get<AdaptiveTriangles>(cells_).divisible());
}

void AdaptiveCloth::split(std::span<const GridCell> cells, std::vector<Vec3>& x,
                          std::vector<Vec3>& v) {
  if (grid() != nullptr) return grid()->split(cells, x, v);
  std::vector<std::int32_t> triangles;
  for (const GridCell& cell : cells) triangles.push_back(cell.i);
  std::get<AdaptiveTriangles>(cells_).split(triangles, x, v);
}

}  // namespace selvedge
