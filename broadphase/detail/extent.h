// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>

namespace selvedge::detail {

/// Approximate position and size of a surface, from a few samples and their median, so that
/// outlying vertices have no influence.
struct Extent {
  Vec3 center = Vec3::Zero();
  double size = 0.0;   ///< largest distance along an axis, ignoring a tenth of the vertices
  double reach = 0.0;  ///< rest_extent only: the largest magnitude from which rest positions are
                       ///< computed
};

Extent extent_of(std::span<const Vec3> x);

/// The extent of the rest positions of a surface with a rigid motion.
Extent rest_extent(const SurfaceView& body);

}  // namespace selvedge::detail
