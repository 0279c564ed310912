// SPDX-License-Identifier: MIT
// Uses the broad phase without the cloth: arrays of a moving surface in, candidate pairs out. Two
// square sheets of 7,200 triangles pass each other; brute force finds the same pairs.
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/core/base/types.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <vector>

namespace {

constexpr int kCells = 60;  // a side; two triangles each

std::vector<selvedge::Triangle> grid_triangles(int cells) {
  std::vector<selvedge::Triangle> triangles;
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      const int k = j * (cells + 1) + i;
      triangles.push_back({k, k + 1, k + cells + 2});
      triangles.push_back({k, k + cells + 2, k + cells + 1});
    }
  }
  return triangles;
}

/// A wavy 1 m sheet at the height z.
std::vector<selvedge::Vec3> sheet(int cells, double z) {
  std::vector<selvedge::Vec3> x;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) {
      const double u = double(i) / cells, v = double(j) / cells;
      x.emplace_back(u, v, z + 0.02 * std::sin(20.0 * u) * std::cos(15.0 * v));
    }
  }
  return x;
}

double milliseconds_of(selvedge::BroadPhase& broad_phase, const selvedge::SurfaceView& a,
                       const selvedge::SurfaceView& b, selvedge::CandidatePairs& pairs) {
  const auto start = std::chrono::steady_clock::now();
  broad_phase.find_pairs(a, b, pairs);
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

}  // namespace

int main() {
  const std::vector<selvedge::Triangle> triangles = grid_triangles(kCells);
  const std::vector<selvedge::Edge> edges = selvedge::unique_edges(triangles);
  const std::vector<selvedge::Vec3> still = sheet(kCells, 0.0);
  const std::vector<selvedge::Vec3> before = sheet(kCells, 0.03), after = sheet(kCells, -0.01);
  const selvedge::SurfaceView falling{before, after, edges, triangles, 0.001, 0};
  const selvedge::SurfaceView resting{still, still, edges, triangles, 0.001, 0};

  selvedge::BroadPhaseRegistry methods = selvedge::broad_phases();
  selvedge::CandidatePairs fast, all;
  const double ms = milliseconds_of(*methods.at("bvh_aabb")(), falling, resting, fast);
  milliseconds_of(*methods.at("brute_force")(), falling, resting, all);
  std::printf("%zu triangles a sheet: %zu candidate pairs in %.1f ms\n", triangles.size(),
              fast.size(), ms);

  const bool same = fast.point_triangle == all.point_triangle &&
                    fast.triangle_point == all.triangle_point && fast.edge_edge == all.edge_edge;
  std::printf("brute force finds %s\n", same ? "the same pairs" : "other pairs");
  return same ? 0 : 1;
}
