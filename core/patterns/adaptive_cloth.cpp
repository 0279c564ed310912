// SPDX-License-Identifier: MIT
#include <selvedge/core/patterns/internal/adaptive_cloth.h>

namespace selvedge {
namespace {

std::vector<GridCell> cells_of(const std::vector<std::int32_t>& numbers) {
  std::vector<GridCell> cells;
  for (const std::int32_t i : numbers) cells.push_back({0, i, 0});
  return cells;
}

std::vector<std::int32_t> numbers_of(std::span<const GridCell> cells) {
  std::vector<std::int32_t> numbers;
  for (const GridCell& cell : cells) numbers.push_back(cell.i);
  return numbers;
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

TriangleMesh AdaptiveCloth::rest() const {
  return grid() != nullptr ? grid()->cloth().surface : std::get<AdaptiveTriangles>(cells_).rest();
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
  std::get<AdaptiveTriangles>(cells_).split(numbers_of(cells), x, v);
}

std::vector<GridCell> AdaptiveCloth::flat(std::span<const Vec3> x, double angle,
                                          double limit) const {
  if (grid() != nullptr) return grid()->flat(x, angle, limit);
  return cells_of(std::get<AdaptiveTriangles>(cells_).flat(x, angle, limit));
}

std::vector<Vec3> AdaptiveCloth::flattened(std::span<const GridCell> cells,
                                           std::span<const Vec3> x) const {
  if (grid() != nullptr) return grid()->flattened(cells, x);
  return std::get<AdaptiveTriangles>(cells_).flattened(numbers_of(cells), x);
}

std::vector<std::int32_t> AdaptiveCloth::join(std::span<const GridCell> cells, std::vector<Vec3>& x,
                                              std::vector<Vec3>& v) {
  if (grid() != nullptr) return grid()->join(cells, x, v);
  return std::get<AdaptiveTriangles>(cells_).join(numbers_of(cells), x, v);
}

std::vector<std::int32_t> AdaptiveCloth::nodes(const GridCell& cell) const {
  if (grid() != nullptr) return grid()->nodes(cell);
  return std::get<AdaptiveTriangles>(cells_).nodes(cell.i);
}

}  // namespace selvedge
