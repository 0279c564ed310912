// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/cloth_mesh.h>

#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

/// Warns of a piece that has an edge shorter than its rest gap. Contacts between such neighbours
/// keep a part of their starting distance, so the cloth cannot fold as sharply as its mesh allows.
void warn_of_rest_gap(const ClothMesh& piece, double rest_gap, const std::string& place,
                      std::vector<std::string>& warnings);

/// How fine the triangles of a surface are.
struct SurfaceGrain {
  double vertices = 0.0;  ///< that triangles have
  double area = 0.0;      ///< m²

  /// The distance of neighbouring vertices, m.
  double cell() const;
  /// The number of vertices within `reach` (m) of one, if the surface is flat there.
  double within(double reach) const;
};
SurfaceGrain grain_of(std::span<const Vec3> x, std::span<const Triangle> triangles);

/// Refuses a rest gap of so many cells that the pairs in reach would take gigabytes, for a piece
/// and another surface, or the piece `itself`. Throws std::invalid_argument with the fault and the
/// remedy.
void refuse_rest_gap(const SurfaceGrain& piece, const SurfaceGrain& other, bool itself,
                     double rest_gap);

}  // namespace selvedge::detail
