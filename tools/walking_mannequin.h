// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/tools/mannequin.h>

#include <vector>

namespace selvedge {

/// The mannequin with joints that bend. Vertices and triangles are the same in every pose, so its
/// frames form a sequence body. The skin follows the bones by linear blending; the weights depend
/// on the distance to each bone and its neighbours along the chain and are smoothed over the mesh.
/// The surface is free of self-intersections within the joint angles of a walk, but not necessarily
/// far from the initial pose `config`.
class BendingMannequin {
 public:
  /// Throws std::invalid_argument naming the field outside its range.
  explicit BendingMannequin(const MannequinConfig& config);

  const std::vector<Triangle>& triangles() const { return surface_.triangles; }
  /// Vertex positions (m) in another pose, with the lower foot on z = 0.
  std::vector<Vec3> bent(const LimbPose& left, const LimbPose& right) const;

 private:
  MannequinConfig config_;
  TriangleMesh surface_;
  std::vector<std::vector<double>> weights_;  // per vertex and bone
};

/// Timing of the walk.
struct WalkConfig {
  double cycle = 1.1;    ///< s, duration of two steps, > 0
  double stride = 0.36;  ///< rad, swing of the thighs forward and backward, in [0, 0.45]
  double start = 1.0;    ///< s, from standing still to full stride, > 0
};

/// Pose of the walk at one time: the figure stands before time 0 and then walks towards -y.
struct WalkPose {
  LimbPose left, right;
  double way = 0.0;  ///< m, distance covered by a figure of 1.7 m height
};
/// Pose at `time` (s). Throws std::invalid_argument naming a bad field.
WalkPose walk_at(double time, const WalkConfig& config = {});

}  // namespace selvedge
