// SPDX-License-Identifier: MIT
#pragma once

// Shapes for tests of the judge.

#include <selvedge/core/base/types.h>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace selvedge {

inline const std::array<Vec3, 3> unit{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};

inline TriangleMesh cube(const Vec3& low, const Vec3& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.emplace_back(i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1],
                               i & 4 ? high[2] : low[2]);
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

// A square sheet of cells × cells pairs of triangles in the unit square, with the given height.
template <class Height>
inline TriangleMesh sheet(int cells, const Height& height) {
  TriangleMesh mesh;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      const double x = static_cast<double>(i) / cells, y = static_cast<double>(j) / cells;
      mesh.vertices.emplace_back(x, y, height(x, y));
    }
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const std::int32_t a = j * (cells + 1) + i, b = a + 1, c = a + cells + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  return mesh;
}

inline TriangleMesh points_only(std::vector<Vec3> x) { return {std::move(x), {}}; }

inline void append(TriangleMesh& all, const TriangleMesh& piece) {
  const auto first = static_cast<std::int32_t>(all.vertices.size());
  all.vertices.insert(all.vertices.end(), piece.vertices.begin(), piece.vertices.end());
  for (const auto& [a, b, c] : piece.triangles)
    all.triangles.push_back({a + first, b + first, c + first});
}

inline TriangleMesh flipped(TriangleMesh mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

}  // namespace selvedge
