// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>

#include <vector>

namespace selvedge {

/// A box of a hierarchy, m.
struct LevelBox {
  Vec3 lo, hi;
};

/// The boxes of the tree that bvh_aabb builds for this surface, to look at: level 0 is the root,
/// each next level is the last one with every node replaced by its children. Each level thus holds
/// all primitives. The last one is made of leaves alone. Throws std::invalid_argument as bvh_aabb
/// does; of an empty surface there are no levels.
std::vector<std::vector<LevelBox>> hierarchy_levels(const SurfaceView& surface);

}  // namespace selvedge
