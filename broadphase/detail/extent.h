// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>

namespace selvedge::detail {

/// About where a surface is and how large, by few samples and their median, so that vertices that
/// fly far away do not count.
struct Extent {
  Vec3 center = Vec3::Zero();
  double size = 0.0;   ///< largest distance along an axis, but for a tenth of the vertices
  double reach = 0.0;  ///< rest_extent only: the largest number that rest positions come from
};

Extent extent_of(std::span<const Vec3> x);

/// Of the rest positions of a surface with a rigid motion.
Extent rest_extent(const SurfaceView& body);

}  // namespace selvedge::detail
