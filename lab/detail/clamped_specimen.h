// SPDX-License-Identifier: MIT
//
// Tests of swatches between clamps, each state an equilibrium.
#pragma once

#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/lab/fabric_drape.h>

#include <array>
#include <cstddef>
#include <vector>

namespace selvedge::detail {

/// Cloth, and the directions along and across the pull at rest.
struct Specimen {
  ClothMesh cloth;
  Vec3 along, across;
  double length = 0.0;            ///< m, between the grips
  double grip = 0.0;              ///< m, that particles are held inside of this length
  double middle = 0.0;            ///< m, half of the width whose force is measured
  double width = 0.0;             ///< m, that bears this force
  std::size_t surface = 0;        ///< the first vertices, which belong to triangles
  std::array<double, 2> frame{};  ///< m, half of the opening of a frame, along and across
};

/// Two ends, whose grips let the specimen contract across; the same with a surface that stays in
/// its plane; or a frame with hinged corners.
enum class Clamps { ends, flat_ends, frame };

/// Pulls or shears a specimen step by step to equilibrium; the first point is the state at rest.
/// Throws std::runtime_error if a step finds no equilibrium. Gives the last state, in the
/// coordinates along, across and up, in `last` unless it is null.
std::vector<SwatchPoint> pull_specimen(Specimen specimen, Clamps clamps, double strain,
                                       std::int32_t points, std::vector<Vec3>* last = nullptr);

}  // namespace selvedge::detail
