// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// The limb of each vertex, 0 to count - 1; each limb has at least one vertex.
struct Limbs {
  std::vector<std::int32_t> of_vertex;
  std::int32_t count = 0;
};

/// Cuts a surface, at the start of the step, into parts that are long and unbranched as far as
/// possible. Slabs across `axis` (zero: across the longest extent) fall into connected pieces.
/// Pieces of neighbouring slabs belong to one limb if each is the other's only neighbour on that
/// side and their thicknesses are similar. Each limb is cut again across its own longest extent.
/// Small unconnected pieces together form one limb.
///
/// Every result is valid for conservative use: it affects only how tight the enclosure is. Vertices
/// must be finite and indices in range.
Limbs find_limbs(const SurfaceView& surface, const Vec3& axis);

/// The whole surface as one limb.
Limbs one_limb(const SurfaceView& surface);

/// Unit direction of the largest spread of these vertices at the start of the step; x if there is
/// none.
Vec3 longest_axis(const SurfaceView& surface, std::span<const std::int32_t> vertices);

}  // namespace selvedge::detail
