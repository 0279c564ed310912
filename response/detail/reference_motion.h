// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>
#include <selvedge/response/detail/contact_groups.h>
#include <selvedge/response/response.h>

#include <cmath>
#include <span>
#include <string>

namespace selvedge::detail {

/// The motion of a group of particles as one piece, d(x) = shift + turn (x - centre). I + t·turn is
/// invertible at every t in [0,1], so the straight paths x -> x + d(x) form one invertible affine
/// map at every instant: a set that moves this way cannot collide with itself.
struct ReferenceMotion {
  Vec3 shift = Vec3::Zero();   ///< m
  Vec3 centre = Vec3::Zero();  ///< m
  Mat3 turn = Mat3::Zero();    ///< linear part of the displacement
  /// Largest distance of an anchor from this motion, relative to the extent of the anchors; 0: all
  /// anchors follow it exactly.
  double residual = 0.0;

  /// d(x), m.
  Vec3 displacement(const Vec3& x) const { return shift + turn * (x - centre); }
};

/// The motion of free particles: the displacement V + Ω × r of the rigid velocity that has their
/// linear momentum and their angular momentum Σ m x_t0 × (x_t1 - x_t0). Of all displacements with
/// these momenta it has the least Σ m |d|²: the perfectly inelastic end. It keeps both momenta
/// exactly, and its determinant 1 + t²|Ω|² is never 0. In return it stretches by |Ω|²/2 across the
/// axis; the rotation by |Ω| of [Bridson2002, section 7.5] keeps the shape but changes angular
/// momentum and energy by that much.
ReferenceMotion momentum_motion(std::span<const std::int32_t> particles,
                                std::span<const double> mass, std::span<const Vec3> x_t0,
                                std::span<const Vec3> x_t1);

/// The motion of anchors: their common displacement, bit for bit, if they share one; otherwise the
/// best rigid fit [Kabsch1976], with the distance from it in `residual`.
ReferenceMotion anchor_motion(std::span<const std::int32_t> anchors, std::span<const Vec3> x_t0,
                              std::span<const Vec3> x_t1);

/// Anchors whose residual exceeds this value do not move as one rigid body.
inline constexpr double kRigidResidual = 1e-6;

/// Ω| of a motion whose turn is the cross product with Ω; 2 sin(θ/2) for a rotation by θ.
inline double angle_of(const ReferenceMotion& motion) {
  return motion.turn.norm() / std::sqrt(2.0);
}

/// One translation for all particles, m, relative to which displacements may be bounded: the
/// mid-range of the displacements of the anchors that `hits` meet or, without anchors, the mean
/// displacement of all particles.
Vec3 shared_shift(std::span<const ContactPoint> hits, const ResponseStep& step,
                  std::span<const Vec3> x_t1);

/// A message that names the particles of a jammed group and the two of its anchors whose motions
/// differ most.
std::string jam_sentence(const ContactGroup& group, const ContactMotion& motion,
                         std::span<const Vec3> x_t1);

}  // namespace selvedge::detail
