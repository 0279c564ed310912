// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/resolution.h>
#include <selvedge/core/base/collision_types.h>

namespace selvedge::detail {

/// A segment along which a vertex moves, and the distance from it that the vertex covers.
struct VertexPath {
  Vec3 y_t0, y_t1;
  double reach;
};

/// The path in the world.
inline VertexPath path_of(const SurfaceView& surface, std::int32_t v) {
  return {surface.x_t0[v], surface.x_t1[v], surface.thickness};
}

/// The frame of a body that moves rigidly over one step, x₀ = R₀X + p₀ and x₁ = R₁X + p₁. In this
/// frame the body is at rest and other surfaces are bounded.
///
/// Every vertex moves straight, so at time t the body's point X is at A(t)X + q(t) with A = (1-t)R₀
/// + tR₁ and q = (1-t)p₀ + tp₁. Let θ be the angle of R₀ᵀR₁. Then |Av| >= cos(θ/2)|v| and |R₀ - R₁|
/// = 2 sin(θ/2). Another surface's point c(t) = (1-t)c₀ + tc₁ has in the body's coordinates the
/// position z(t) = A⁻¹(c - q), with ends z₀ = R₀ᵀ(c₀ - p₀) and z₁ = R₁ᵀ(c₁ - p₁). It deviates from
/// its chord l(t) = (1-t)z₀ + tz₁ by
///   A(z - l) = t(1-t)(R₀ - R₁)(z₀ - z₁),  so  |z - l| <= ½ tan(θ/2)·|z₁ - z₀|,
/// and everything within D of c in the world is within D/cos(θ/2) of z. The position of a point of
/// an edge or a triangle is, at each time, the same weighted mean of its vertices' positions. So
/// the segment z₀z₁, widened by both bounds and by the body's own reach, bounds everything that
/// could touch: no contact is lost, and the body's own boxes never change.
class RigidFrame {
 public:
  /// `size` is the largest |X|₁, and thickness that of the body. Throws std::invalid_argument if a
  /// matrix is not a rotation.
  RigidFrame(const RigidMotion& motion, double size, double thickness);

  /// False if the body rotates so far in the step that the bounds would be of little use.
  bool serves() const { return half_cosine_ >= kLeastHalfCosine; }

  Vec3 to_body_t0(const Vec3& x) const { return to_body_t0_ * (x - p_t0_); }
  Vec3 to_body_t1(const Vec3& x) const { return to_body_t1_ * (x - p_t1_); }

  /// The path of a vertex of another surface.
  VertexPath path_of_other(const SurfaceView& surface, std::int32_t v) const;

 private:
  static constexpr double kLeastHalfCosine = 0.7;  // a quarter turn

  Mat3 to_body_t0_, to_body_t1_;
  Vec3 p_t0_, p_t1_;
  double half_cosine_, half_sine_;  ///< of θ/2, the sine rounded up, the cosine rounded down
  double body_reach_;               ///< thickness and rounding of the body
};

/// The frame and origin (or maps) of the coordinates of a tree.
struct TreePlace {
  Vec3 origin = Vec3::Zero();
  const RigidFrame* frame = nullptr;  ///< null: the world
  bool is_body = false;               ///< the surface is the body of the frame
  /// One map for each direction of the tree's volumes instead of the origin, in the world frame
  /// only; null: none.
  const QuantileMap* maps = nullptr;

  VertexPath path_of(const SurfaceView& surface, std::int32_t v) const {
    if (!frame) return detail::path_of(surface, v);
    if (!is_body) return frame->path_of_other(surface, v);
    const Vec3 rest = frame->to_body_t0(surface.x_t0[v]);
    return {rest, rest, 0.0};
  }
};

}  // namespace selvedge::detail
