// SPDX-License-Identifier: MIT
//
// Where a surface passes through another one exactly along an edge, no two triangles cross: each
// lies on one side. The two triangles at the edge tell together.
#pragma once

#include <selvedge/core/base/collision_types.h>
#include <selvedge/detection/find.h>

namespace selvedge::detail {

/// Moves the pairs of `found` in which triangles at an edge of one surface pass through a triangle
/// of the other along that edge from the touches to the crossings. For one surface pass it twice.
void move_passages(const SurfaceView& a, const SurfaceView& b, TriangleMeetings& found);

}  // namespace selvedge::detail
