// SPDX-License-Identifier: MIT
//
// Grids that are split at random, shared by the tests of adaptive meshes.
#pragma once

#include <selvedge/core/patterns/cloth_pattern.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "dense_force.h"

namespace selvedge::adaptive_grids {

inline double sum(const std::vector<double>& values) {
  double total = 0.0;
  for (const double v : values) total += v;
  return total;
}

inline Vec3 momentum(const std::vector<double>& mass, const Vectors& v) {
  Vec3 total = Vec3::Zero();
  for (std::size_t i = 0; i < v.size(); ++i) total += mass[i] * v[i];
  return total;
}

inline const GridConfig kGrid{0.6, 0.4, 6, 4};

/// Split at random: levels beside one another, corners, borders.
inline AdaptiveGrid ragged(const GridConfig& grid, const Material& material, unsigned seed,
                           int rounds = 3, Vectors* x = nullptr, Vectors* v = nullptr) {
  AdaptiveGrid adaptive(grid, material, 3);
  std::mt19937 generator(seed);
  for (int round = 0; round < rounds; ++round) {
    std::vector<GridCell> some;
    for (const GridCell& cell : adaptive.divisible())
      if (generator() % 4 == 0) some.push_back(cell);
    if (x != nullptr)
      adaptive.split(some, *x, *v);
    else
      adaptive.split(some);
  }
  return adaptive;
}

inline std::vector<std::pair<Edge, double>> springs_by_place(const ClothMesh& cloth) {
  // Vertices are numbered differently; rest positions tell which is which.
  std::vector<std::pair<std::array<double, 4>, double>> list;
  for (const Spring& s : cloth.springs) {
    const Vec3 a = cloth.surface.vertices[s.a], b = cloth.surface.vertices[s.b];
    const bool swap = std::pair(a.x(), a.y()) > std::pair(b.x(), b.y());
    const Vec3 p = swap ? b : a, q = swap ? a : b;
    list.push_back({{p.x(), p.y(), q.x(), q.y()}, s.stiffness});
  }
  std::sort(list.begin(), list.end());
  std::vector<std::pair<Edge, double>> rounded;
  constexpr double grain = 1e6;
  for (const auto& [place, k] : list)
    rounded.push_back({{static_cast<std::int32_t>(std::lround(grain * (place[0] + 7 * place[1]))),
                        static_cast<std::int32_t>(std::lround(grain * (place[2] + 7 * place[3])))},
                       std::round(k * grain) / grain});
  std::sort(rounded.begin(), rounded.end());
  return rounded;
}

}  // namespace selvedge::adaptive_grids
