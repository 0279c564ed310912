// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/build.h>

#include <span>

namespace selvedge::detail {

/// How far a body rises above an edge of cloth of the given length (m) whose ends lie on it: at
/// most this (m) along all but 2 % of its edges. A turn between two triangles is a corner for an
/// edge shorter than their width, else a part of an arc.
double rise_above_edge(std::span<const Vec3> x, std::span<const Triangle> triangles, double length);

/// Warns of bodies that a detector of particles alone cannot keep off the cloth: those that rise by
/// more than half of the rest gap above an edge of a piece, and those thinner than the rest gap.
void warn_between_particles(const Scene& scene, BuiltScene& built);

}  // namespace selvedge::detail
