// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/core/base/types.h>

#include <cstdint>
#include <vector>

namespace selvedge {

/// A surface that owns its arrays.
struct OwnedSurface {
  std::vector<Vec3> x_t0, x_t1;
  std::vector<Edge> edges;
  std::vector<Triangle> triangles;
  double thickness = 0.0;
  std::uint64_t static_id = 0;
  RigidMotion rigid{};  ///< in use if its id is not 0

  SurfaceView view() const {
    return {x_t0, x_t1, edges, triangles, thickness, static_id, rigid.id ? &rigid : nullptr};
  }
  /// Edges of the triangles, at rest.
  void close() {
    x_t1 = x_t0;
    edges = unique_edges(triangles);
  }
};

/// A flat sheet of nx × ny cells at rest, with sides of length `size`.
inline OwnedSurface flat_sheet(int nx, int ny, double size) {
  OwnedSurface s;
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) s.x_t0.push_back({size * i / nx, size * j / ny, 0.0});
  const auto at = [nx](int i, int j) { return j * (nx + 1) + i; };
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      s.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      s.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  s.close();
  return s;
}

}  // namespace selvedge
