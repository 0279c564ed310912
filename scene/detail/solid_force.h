// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/force.h>

#include <array>
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

/// A point of a rigid body that something outside holds at its place.
struct Pin {
  std::int32_t leader;           ///< first of the four
  std::array<double, 4> weight;  ///< of the leaders
  Vec3 place;                    ///< m
  double stiffness;              ///< N/m
};

/// Slows a leader by its velocity.
struct Damper {
  std::int32_t particle;
  double damping;  ///< N·s/m
};

/// The force of what holds and slows bodies at their joints.
std::unique_ptr<Force> make_joints(std::vector<Pin> pins, std::vector<Damper> dampers);

}  // namespace selvedge::detail
