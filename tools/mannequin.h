// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

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

}  // namespace selvedge
