// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/analytic_body.h>
#include <selvedge/narrowphase/narrow_phase.h>

namespace selvedge {

/// A particle and an analytic body over one step.
struct ParticleContact {
  double toi = kNoCollision;   ///< first time on or inside the body; kNoCollision if never
  Vec3 point = Vec3::Zero();   ///< place of the particle at toi, metres
  Vec3 normal = Vec3::Zero();  ///< outward unit normal of the body there
  double distance_t0 = 0.0;    ///< signed distance at t = 0, metres, negative inside
  double distance_t1 = 0.0;    ///< the same at t = 1
};

/// The first contact of a particle on the straight line x_t0 -> x_t1, t in [0, 1], with the shape,
/// in the shape's own coordinates: for a body that moves without turning take its motion away from
/// the particle's. Touching counts; a particle that starts inside is in contact at t = 0.
///
/// Closed forms; for the torus the roots of a quartic enclosed by subdivision. The signed distance
/// at `point` is zero within kParticleAccuracy times the largest coordinate or size (torus: times
/// that again over `tube`); a path that misses or enters the body by less may get either verdict.
/// The plane's verdict is exact.
///
/// Throws std::invalid_argument for coordinates that are not finite and sizes that are not positive
/// and finite.
ParticleContact particle_body_contact(const AnalyticShape& shape, const Vec3& x_t0,
                                      const Vec3& x_t1);

/// See particle_body_contact: 2^9 roundings, of which a path takes a few dozen.
inline constexpr double kParticleAccuracy = 0x1p-44;

/// Unit gradient of signed_distance at x: the outward normal of the nearest place of the surface,
/// of one of them if there are several.
Vec3 outward_normal(const AnalyticShape& shape, const Vec3& x);

}  // namespace selvedge
