// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>
#include <selvedge/detection/find.h>

#include <span>
#include <string>
#include <vector>

// Collisions along true rotations. find_collisions moves every vertex on a straight line, the chord
// of its arc: a body that turns by 180 degrees in a step shrinks to its axis half way. The function
// below follows the arcs.

namespace selvedge {

/// A rigid motion during a step, t in [0,1]: at constant speed about an axis that moves on a
/// straight line. A screw motion is one whose translation is parallel to the axis.
struct RotatingMotion {
  Vec3 pivot = Vec3::Zero();        ///< m, a point of the axis at t = 0
  Vec3 turn = Vec3::Zero();         ///< rad, the axis times the angle, which may exceed a full turn
  Vec3 translation = Vec3::Zero();  ///< m, of the axis during the step
};

/// Position at time t of a point that starts at `x_t0`, m.
Vec3 position_at(const RotatingMotion& motion, const Vec3& x_t0, double t);

/// The motion from one pose of a rigid body to another, about the body's own origin, by the shorter
/// way: the turn is at most half a circle.
RotatingMotion motion_between(const Pose& t0, const Pose& t1);

/// Largest distance (m) between the arc of a point at `radius` (m) from the axis and its chord, for
/// an angle in rad, at equal times: r a²/8, the bound for linear interpolation. The sagitta
/// r (1 - cos(a/2)) is never larger.
double chord_deviation(double radius, double angle);

/// One rigid surface during one step. This is a view: its creator keeps the arrays alive.
struct RotatingSurface {
  std::span<const Vec3> x_t0;           ///< (n,3), metres
  std::span<const Triangle> triangles;  ///< (k,3), vertex indices
  RotatingMotion motion;
};

/// Options of find_rotating_collisions.
struct RotationConfig {
  std::string broad_phase = "bvh_aabb";  ///< a conservative detector of broad_phases()
  /// m, > 0. A reported pair comes at least this near. Half of it doubles the number of tests of a
  /// pair that comes so near, and does not affect others.
  double tolerance = 1e-4;
};

/// Finds the collisions between two surfaces, one or both of which rotate. It reports every pair of
/// primitives that share a point while all vertices follow their arcs, and no pair that stays
/// farther apart than the tolerance. toi is never later than the first common point; at toi the
/// pair is at most the tolerance apart. Sorted as find_collisions.
///
/// Method: the arcs are cut into pieces, and each piece is its chord, inflated by the proven
/// deviation. The narrow phase decides chords exactly, with the deviation as minimum separation.
/// The pieces of a pair that may collide are halved, which divides the deviation by four, until the
/// deviation is a share of the tolerance.
///
/// Throws as find_collisions, and std::invalid_argument for a motion that is not finite, a detector
/// that may miss pairs, and a tolerance that is not positive or too small for the rounding of
/// coordinates of that size.
std::vector<Collision> find_rotating_collisions(const RotatingSurface& a, const RotatingSurface& b,
                                                const RotationConfig& config = {});
std::vector<Collision> find_rotating_collisions(const RotatingSurface& a, const MovingSurface& b,
                                                const RotationConfig& config = {});

}  // namespace selvedge
