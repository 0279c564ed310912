// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth_mesh.h>

namespace selvedge {

/// A grid cloth in motion at one level of fineness.
struct LevelState {
  GridConfig grid;
  std::vector<Vec3> x;  ///< m, per vertex of the grid, row by row
  std::vector<Vec3> v;  ///< m/s
};

/// The same cloth on cells of half the size: positions and velocities are interpolated bilinearly.
/// A mesh of the finer grid and the same material has the same mass, momentum and centre of mass
/// and the same continuum constants and plate rigidity, as these come from the fabric; the bilinear
/// surface passes through the coarse vertices. Angular momentum and energies change by O(cell²).
/// Throws std::invalid_argument where the sizes do not fit, or the finer grid would be too large.
LevelState refine(const LevelState& coarse);

/// Whether a phase of a multi-level run is over: nothing is faster than `speed`, m/s.
bool has_settled(const LevelState& state, double speed);

}  // namespace selvedge
