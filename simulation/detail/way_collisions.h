// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>
#include <selvedge/simulation/simulation.h>

#include <cstdint>
#include <set>
#include <span>

namespace selvedge::detail {

/// Straight paths of the cloth vertices from where they are to where a change of the mesh puts
/// them.
struct ClothWay {
  const Simulation& simulation;
  const Scene& scene;          ///< of the simulation
  std::span<const Vec3> x_t1;  ///< m, of all cloth vertices
  /// The number of each vertex after the change. Primitives that have a vertex in common then do
  /// not collide. Empty: vertices keep their numbers.
  std::span<const std::int32_t> after{};
};

/// The cloth vertices that collide on their paths with cloth or bodies at rest, as they are
/// numbered after the change. Decided exactly. Pairs that the scene excludes from detection
/// ("contact.self", "collide" of "contact.pairs") do not count.
std::set<std::int32_t> colliding_on_way(const ClothWay& way);

}  // namespace selvedge::detail
