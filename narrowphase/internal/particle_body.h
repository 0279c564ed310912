// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/body.h>
#include <selvedge/narrowphase/narrow_phase.h>

namespace selvedge {

/// First contact of a particle with an analytic body in one step.
struct ShapeContact {
  double toi = kNoCollision;   ///< first time on or inside the body; kNoCollision if there is none
  Vec3 point = Vec3::Zero();   ///< metres, position of the particle at toi
  Vec3 normal = Vec3::Zero();  ///< outward unit normal of the body there
  double distance_t0 = 0.0;    ///< metres, signed distance at t = 0, negative inside
  double distance_t1 = 0.0;    ///< metres, the same at t = 1
};

/// The first contact of a particle on the straight line x_t0 -> x_t1 (metres), t in [0, 1], with
/// the shape, in the shape's own coordinates. For a body that moves without rotation, subtract its
/// motion from the particle's. Touching counts; a particle that starts inside is in contact at t =
/// 0.
///
/// Closed forms, except for the torus, where subdivision encloses the roots of a quartic. The
/// signed distance at `point` is zero within kParticleAccuracy times the largest coordinate or size
/// (torus: multiplied again by that size over `tube`). A path that misses or enters the body by
/// less than that may get either result. For the plane the result is exact.
///
/// Throws std::invalid_argument for coordinates that are not finite and sizes that are not positive
/// and finite.
ShapeContact particle_body_contact(const AnalyticShape& shape, const Vec3& x_t0, const Vec3& x_t1);

/// Relative accuracy of particle_body_contact: 2^9 roundings, of which a path uses a few dozen.
inline constexpr double kParticleAccuracy = 0x1p-44;

/// Unit gradient of signed_distance at x: the outward normal at the closest point of the surface,
/// or at one of them if there are several.
Vec3 outward_normal(const AnalyticShape& shape, const Vec3& x);

}  // namespace selvedge
