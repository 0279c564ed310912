// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/build.h>

namespace selvedge::detail {

/// rad/s, of the springs that keep a rigid body in shape and on its line: 1.9 kHz. Under a force F,
/// a body of mass m gives way by F/(m·kSolidFrequency²): 1 kg under 10 N by 0.07 µm.
inline constexpr double kSolidFrequency = 12000.0;

/// The rigid body within a closed surface: the vertices of the surface and after them its leaders,
/// four point masses at alternate corners of the box about its principal axes whose half sizes are
/// the radii of gyration, tied by springs: they have its mass, centre and moments of inertia.
/// Throws std::invalid_argument for a surface that is open or turned inwards.
ClothMesh make_solid(const TriangleMesh& surface, const SolidSpec& solid);

/// What the scene needs to know of a piece that make_solid has made and that begins at vertex
/// `begin` of `all`.
BuiltSolid built_solid(std::size_t piece, std::int32_t begin, const SolidSpec& solid,
                       const ClothMesh& all);

}  // namespace selvedge::detail
