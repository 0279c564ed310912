// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <span>
#include <string>

namespace selvedge {

/// Whether the vertices of a mesh leap between two of its frames, as when a program has
/// renumbered them. A body moves its vertices along straight lines, so that such a body passes
/// through itself and through cloth. A sentence part such as "8 of 8 vertices leap ...", with a
/// remedy; empty for a body that moves, turns and bends, by less than about a quarter turn.
std::string vertex_leap(std::span<const Vec3> from, std::span<const Vec3> to,
                        std::span<const Edge> edges);

}  // namespace selvedge
