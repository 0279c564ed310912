// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>

#include <vector>

namespace selvedge {

/// A box of a hierarchy, m.
struct LevelBox {
  Vec3 lo, hi;
};

/// The boxes of the tree that bvh_aabb builds for this surface, for visualisation. Level 0 is the
/// root; each further level replaces every node of the previous one by its children, so each level
/// contains all primitives. The last level consists of leaves only. Throws std::invalid_argument as
/// bvh_aabb does; an empty surface has no levels.
std::vector<std::vector<LevelBox>> hierarchy_levels(const SurfaceView& surface);

}  // namespace selvedge
