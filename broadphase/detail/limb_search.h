// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Which limb each vertex belongs to, 0 to count - 1, each with a vertex at least.
struct Limbs {
  std::vector<std::int32_t> of_vertex;
  std::int32_t count = 0;
};

/// Cuts a surface, as it is at the start of the step, into parts that are each long and without
/// branches, as far as they can be found: slabs across `axis` (zero: across the longest extent)
/// fall into connected pieces, and pieces of neighbouring slabs belong to one limb where each has
/// but the other on that side and neither is much thicker than the other. Each limb found is cut
/// again, across its own longest extent. What is unconnected and small is one limb together.
///
/// Any answer is right for a conservative use: the cut is only more or less tight. Vertices must be
/// finite and indices in range.
Limbs find_limbs(const SurfaceView& surface, const Vec3& axis);

/// The whole surface as one limb.
Limbs one_limb(const SurfaceView& surface);

/// Unit direction of the largest spread of these vertices at the start of the step; x if there is
/// none.
Vec3 longest_axis(const SurfaceView& surface, std::span<const std::int32_t> vertices);

}  // namespace selvedge::detail
