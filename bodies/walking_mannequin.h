// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/mannequin.h>

#include <vector>

namespace selvedge {

/// The mannequin with joints that bend: the same vertices and triangles in every pose, so that its
/// frames are a sequence body. The skin follows the bones by linear blending of their motions, with
/// weights by the distance to each bone along the chain of its neighbours, smoothed over the mesh.
/// Within the angles of a walk the surface stays free of self-intersections; far from the pose in
/// which it was made (`config`) it need not.
class BendingMannequin {
 public:
  /// Throws std::invalid_argument naming the field outside its range.
  explicit BendingMannequin(const MannequinConfig& config);

  const std::vector<Triangle>& triangles() const { return surface_.triangles; }
  /// The vertices in another pose, the lower foot on z = 0, m.
  std::vector<Vec3> bent(const LimbPose& left, const LimbPose& right) const;

 private:
  MannequinConfig config_;
  TriangleMesh surface_;
  std::vector<std::vector<double>> weights_;  // per vertex and bone
};

struct WalkConfig {
  double cycle = 1.1;    ///< s, two steps, > 0
  double stride = 0.36;  ///< rad, swing of the thighs to each side, in [0, 0.45]
  double start = 1.0;    ///< s, from standing to full stride, > 0
};

/// The walk at a time in seconds: standing before 0, then towards -y.
struct WalkPose {
  LimbPose left, right;
  double way = 0.0;  ///< m, how far the figure has come, for a height of 1.7 m
};
WalkPose walk_at(double time, const WalkConfig& config = {});

}  // namespace selvedge
