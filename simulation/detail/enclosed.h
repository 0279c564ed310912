// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/detection/internal/joint_surface.h>

#include <cstdint>
#include <optional>
#include <span>

namespace selvedge::detail {

/// Connected cloth that lies wholly inside a closed body; joint indices.
struct Enclosed {
  std::int32_t vertex;       ///< its first vertex
  std::int32_t body_vertex;  ///< one of the body's
};

/// The first connected part of the cloth that lies inside a closed body (ClosedParts has the rule),
/// at the positions x of the joint surface. Ignores parts that cross a body, because only a share
/// of them lies inside. `crossings` must contain all crossings between cloth and bodies.
std::optional<Enclosed> find_enclosed(const JointSurface& surface, std::span<const Vec3> x,
                                      std::span<const EdgeCrossing> crossings);
/// How many of these vertices lie inside a closed body.
int count_inside(const JointSurface& surface, std::span<const Vec3> x,
                 std::span<const std::int32_t> vertices);

}  // namespace selvedge::detail
