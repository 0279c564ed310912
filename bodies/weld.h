// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <cstddef>

namespace selvedge {

/// What weld_vertices has done to a mesh.
struct WeldReport {
  std::size_t vertices = 0;   ///< before
  std::size_t joined = 0;     ///< of these, how many became one with another
  std::size_t collapsed = 0;  ///< triangles that lost a corner and are gone
  double farthest = 0.0;      ///< m, largest distance of two vertices that became one
};

/// Joins vertices that are at most `distance` apart, m: each with the nearest one before it that
/// was not joined itself, whose position it takes. Removes triangles that lose a corner, and
/// vertices of no triangle. The result depends on the order of the vertices alone. Throws
/// std::invalid_argument unless the distance is finite and > 0.
WeldReport weld_vertices(TriangleMesh& mesh, double distance);

}  // namespace selvedge
