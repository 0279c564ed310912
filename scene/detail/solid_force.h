// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/force.h>

#include <memory>
#include <vector>

namespace selvedge::detail {

/// A spring between two leaders of a rigid body.
struct Rod {
  std::int32_t a, b;
  double length;     ///< m
  double stiffness;  ///< N/m
};

/// The force of all rods. Its Jacobian has their direction alone: an implicit step then solves for
/// their lengths and leaves the angular momentum of the body as it is. With the part across, which
/// turns a stretched rod back, a body that spins would stop within a few turns.
std::unique_ptr<Force> make_rods(std::vector<Rod> rods);

}  // namespace selvedge::detail
