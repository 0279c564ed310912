// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/grid_engine.h>

#include <stdexcept>

namespace selvedge::detail {
namespace {

/// Spacing of boxes that fill their common box evenly, along its longest side.
double typical_spacing(const std::vector<DoubleBox>& boxes, const FloatMap& map) {
  double span = 0.0;
  for (int k = 0; k < 3 && !boxes.empty(); ++k) {
    const auto [lo, hi] = std::minmax_element(
        boxes.begin(), boxes.end(),
        [k](const DoubleBox& a, const DoubleBox& b) { return a.lo[k] < b.lo[k]; });
    span = std::max(span, map(k, hi->lo[k]) - map(k, lo->lo[k]));
  }
  return span > 0.0 ? span / std::sqrt(static_cast<double>(boxes.size())) : 1.0;
}

/// Clamps to the range of normal floats.
double bounded(double extent) {
  return std::clamp<double>(extent, std::numeric_limits<float>::min(),
                            std::numeric_limits<float>::max());
}

}  // namespace

double checked_cell(double cell, const std::string& detector) {
  if (!(cell > 0.0) || !std::isfinite(cell))
    throw std::invalid_argument(detector + ": cell must be finite and greater than 0, not " +
                                std::to_string(cell));
  return cell;
}

MethodOption cell_option() {
  return {.name = "cell",
          .initial = CellGridConfig{}.cell,
          .unit = "1",
          .least = 0.0,
          .most = 1e6,
          .above_least = true,
          .meaning =
              "size of the primitives in the finest grid relative to the typical extent of "
              "an edge's box; smaller: fewer box tests, more cells to visit"};
}

int level_of(float extent, double cell) {
  constexpr double least = 1.0 / (1 << 20);
  const double cells = extent / cell;  // at most 2^101 over the least normal float
  if (!(cells >= least)) return 0;
  // [1/2, 2) cells belong to level 0, [2, 8) to level 1, and so on: 2^e to ceil(e / 2).
  return std::min((std::ilogb(cells) + 1) >> (kLevelBits - 1), kHighestLevel);
}

double typical_extent(const SurfaceBoxes& a, const SurfaceBoxes* b, const FloatMap& map) {
  constexpr std::size_t most = 512;  // of each surface
  std::vector<double> sample;
  for (const auto list : {&SurfaceBoxes::edges, &SurfaceBoxes::triangles, &SurfaceBoxes::points}) {
    for (const SurfaceBoxes* surface : {&a, b}) {
      if (!surface) continue;
      const std::vector<DoubleBox>& boxes = surface->*list;
      const std::size_t step = boxes.size() / most + 1;
      for (std::size_t i = 0; i < boxes.size(); i += step) {
        double extent = 0.0;
        for (int k = 0; k < 3; ++k)
          extent = std::max(extent, map(k, boxes[i].hi[k]) - map(k, boxes[i].lo[k]));
        if (extent > 0.0) sample.push_back(extent);
      }
    }
    if (sample.empty()) continue;
    const auto place = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() / 2);
    std::nth_element(sample.begin(), place, sample.end());
    return bounded(*place);
  }
  return bounded(
      std::max(typical_spacing(a.points, map), b ? typical_spacing(b->points, map) : 0.0));
}

bool place_cells(const SurfaceBoxes& a, const SurfaceBoxes* b, double relative_cell, double finest,
                 FloatMap& map, double& cell) {
  constexpr double similar = 1.25, near = 4096.0;  // near: in cells
  std::vector<const std::vector<DoubleBox>*> lists{&a.points};
  if (b) lists.push_back(&b->points);
  std::vector<DoubleBox> sample;
  for (const SurfaceBoxes* surface : {&a, b})
    if (surface)
      add_sample(surface->triangles.empty() ? surface->edges : surface->triangles, sample);
  const auto cell_under = [&](const FloatMap& m) {
    return std::max<double>(relative_cell * typical_extent(a, b, m),
                            std::numeric_limits<float>::min());
  };
  const auto unresolved = [&](const FloatMap& m, double side) {
    return count_unresolved(sample, m, finest * side);
  };
  FloatMap best(middle_of(lists));
  const double best_cell = cell_under(best);
  if (const int without = unresolved(best, best_cell); without >= kWorthAnotherMap) {
    if (map.is_by_quantiles() && 2 * unresolved(map, cell) <= without) return true;
    FloatMap other(quantile_maps(lists));
    const double other_cell = cell_under(other);
    if (2 * unresolved(other, other_cell) <= without) {
      map = std::move(other);
      cell = other_cell;
      return false;
    }
  }
  if (best_cell < similar * cell && cell < similar * best_cell &&
      map.is_near(best, near * best_cell))
    return true;
  map = std::move(best);
  cell = best_cell;
  return false;
}

}  // namespace selvedge::detail
