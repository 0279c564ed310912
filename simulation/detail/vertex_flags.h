// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/response/response.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation_state.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Input of vertex_flags; views.
struct FlagSources {
  const ClothMesh& cloth;
  std::span<const Vec3> x;                 ///< cloth, m
  std::span<const ContactPoint> contacts;  ///< at the start of the last step
  std::span<const Pinch> pinches;
  const std::vector<Tangle>& tangles;
  bool given_up = false;
  double strain_tolerance = 0.0;  ///< excess that counts as within the limit
};

/// The flag of each cloth vertex, as bits of VertexFlag.
std::vector<std::uint8_t> vertex_flags(const FlagSources& sources);

}  // namespace selvedge::detail
