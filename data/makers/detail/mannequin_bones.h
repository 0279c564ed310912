// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/data/makers/mannequin.h>

#include <vector>

namespace selvedge::detail {

/// The bones of the figure, in this order; the hand moves with the forearm.
enum MannequinBone : std::size_t {
  trunk,
  left_thigh,
  left_shank,
  left_foot,
  right_thigh,
  right_shank,
  right_foot,
  left_upper_arm,
  left_forearm,
  right_upper_arm,
  right_forearm,
  bone_count
};

/// Joint position and axes of a bone in the figure as modelled, 1.7 m high.
struct BoneFrame {
  Mat3 rotation;
  Vec3 origin;  ///< m
};

/// The surface as modelled: 1.7 m high, feet not yet placed on the floor.
TriangleMesh mannequin_surface(const MannequinConfig& config);
std::vector<BoneFrame> mannequin_bones(const MannequinConfig& config);
/// Distance of each point to each bone, m; negative inside.
std::vector<std::vector<double>> bone_distances(const MannequinConfig& config,
                                                const std::vector<Vec3>& x);
/// Moves the lowest point to z = 0 and scales the points to a figure of this height, m.
void stand(std::vector<Vec3>& x, double height);

}  // namespace selvedge::detail
