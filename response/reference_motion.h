// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/types.h>
#include <selvedge/response/contact_groups.h>
#include <selvedge/response/response.h>

#include <cmath>
#include <span>
#include <string>

namespace selvedge {

/// The motion that a group of particles would make as one piece, d(x) = shift + turn (x - centre).
/// As I + t·turn is invertible at every t in [0,1], the straight paths x -> x + d(x) are one
/// invertible affine map at every instant: whatever moves so cannot collide within itself.
struct ReferenceMotion {
  Vec3 shift = Vec3::Zero();   ///< m
  Vec3 centre = Vec3::Zero();  ///< m
  Mat3 turn = Mat3::Zero();    ///< linear part of the displacement
  /// Largest distance of an anchor from this motion, as a share of what they span; 0: none is off.
  double misfit = 0.0;

  Vec3 displacement(const Vec3& x) const { return shift + turn * (x - centre); }
};

/// Of free particles: the displacement V + Ω × r of the rigid velocity that has their linear and
/// angular momentum Σ m x_t0 × (x_t1 - x_t0). Among all displacements with these momenta it has the
/// least Σ m |d|²: the perfectly inelastic end. It keeps both momenta exactly and its determinant
/// 1 + t²|Ω|² is never 0; the price is that it stretches by |Ω|²/2 across the axis, where the
/// rotation by |Ω| of [Bridson2002, section 7.5] keeps the shape and changes angular momentum and
/// energy by that much.
ReferenceMotion momentum_motion(std::span<const std::int32_t> particles,
                                std::span<const double> mass, std::span<const Vec3> x_t0,
                                std::span<const Vec3> x_t1);

/// Of anchors: their common displacement, to the bit, if they share one; else the best rigid fit
/// [Kabsch1976], `misfit` telling how far from it they are.
ReferenceMotion anchor_motion(std::span<const std::int32_t> anchors, std::span<const Vec3> x_t0,
                              std::span<const Vec3> x_t1);

/// Anchors farther than this share of their extent from a rigid motion do not move as one.
inline constexpr double kRigidMisfit = 1e-6;

/// |Ω| of a motion whose turn is the cross product with Ω; 2 sin(θ/2) of one that rotates by θ.
inline double angle_of(const ReferenceMotion& motion) {
  return motion.turn.norm() / std::sqrt(2.0);
}

/// One translation for all, m, from which displacements may be bounded: the middle of those of the
/// anchors that `hits` meet; without any, the mean one of all particles.
Vec3 shared_shift(std::span<const ContactPoint> hits, const ResponseStep& step,
                  std::span<const Vec3> x_t1);

/// Who is between whom: a sentence that names the group and the two of its anchors whose motions
/// differ most.
std::string jam_sentence(const ContactGroup& group, const ContactMotion& motion,
                         std::span<const Vec3> x_t1);

}  // namespace selvedge
