// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <vector>

namespace selvedge {

/// Joint angles of one side of the figure, rad. With all angles zero the figure stands straight
/// with its arms hanging down.
struct LimbPose {
  double shoulder_out = 0.42;   ///< upper arm away from the trunk, sideways; [0.2, 1.5]
  double shoulder_swing = 0.0;  ///< upper arm forward (+) or backward; [-1, 1.5]
  double elbow = 0.15;          ///< forearm bent forward; [0, 1.8]
  double hip_out = 0.14;        ///< thigh away from the other leg, sideways; [0.05, 0.6]
  double hip_swing = 0.0;       ///< thigh forward (+) or backward; [-0.5, 1.2]
  double knee = 0.0;            ///< lower leg bent backward; [0, 1.6]
};

/// Size, mesh and pose of the mannequin.
struct MannequinConfig {
  double height = 1.7;       ///< m, standing, in [0.1, 10]
  int faces = 10000;         ///< target number of triangles, met within 15 %, in [5000, 30000]
  LimbPose left{}, right{};  ///< left: towards +x
};

/// An adult shop-window figure: z up, facing -y, the lower foot on z = 0, the trunk above the
/// origin. The surface is a smooth blend of capsules and ellipsoids, so it is closed,
/// outward-oriented and free of self-intersections in any pose; limbs that come close to each other
/// or to the trunk merge. The same configuration gives bit-identical output. Throws
/// std::invalid_argument naming the field outside its range.
TriangleMesh make_mannequin(const MannequinConfig& config = {});

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
