// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// The vertices of a body that makes room as make_room does, `room[v]` m at vertex v.
std::vector<Vec3> with_room(const TriangleMesh& body, std::span<const double> room);

}  // namespace selvedge::detail
