// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/detail/reference_motion.h>
#include <selvedge/response/fail_safe.h>
#include <selvedge/response/response.h>

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

/// Keeps the two primitives of each pair on opposite sides of a plane. At x_t0, two primitives that
/// do not touch lie on the two sides of a slab (clearances.h). A vertex that is on its side at both
/// ends of a straight path is on it all the time, because its height over the plane is linear in
/// time. The same holds for the convex hulls, so the pair does not meet. The plane may also move on
/// a straight line: in its frame, paths stay straight.
///
/// All planes of a group of particles move with one reference motion: that of the anchors if the
/// group has any, otherwise the mean motion of its particles. "Move as the reference does" then
/// satisfies all planes at once. The remaining displacement δ of a particle is projected onto the
/// half-spaces of its own planes (a follower's δ is the mean of its leaders', which are shortened
/// until it lies in the planes of the follower): motion along the planes stays, except for the
/// Coulomb friction caused by the projection. The plane is placed in its slab where the two sides
/// would meet inelastically.
///
/// Guarantee, for reference motions that are translations: a pair with a plane does not collide.
/// Planes only accumulate and the number of pairs is finite, so the rounds terminate; with the
/// planes of Clearances::all, after one round. If anchors rotate, the heights are not linear in
/// time, and the guarantee holds up to the square of the rotation. A group without anchors keeps
/// its linear momentum (by a translation of the whole group, which does not affect its planes). Σ
/// m|d|² never grows where anchors rest or are absent. Angular momentum is not kept. The guarantee
/// excludes pairs without room: pairs that touch at x_t0, and pairs whose anchors leave their slab,
/// for which `apply` returns false.
///
/// Source: two disjoint convex sets have a separating plane. Reference motions, offsets and
/// friction are ours.
class SeparatingPlanes {
 public:
  /// Starts a step. `x_t1`: end positions of the particles before the projection, metres.
  void begin(const ResponseStep& step, std::span<const Vec3> x_t1);
  /// Adds pairs as Clearances returns them; those of earlier calls in this step remain.
  void add(std::span<const ContactPoint> pairs);
  /// Sets one reference motion for all groups from now on: a translation, m.
  void fix_reference(const Vec3& shift) { shift_ = shift; }
  /// Writes the end positions of the particles of all pairs. Returns false if anchors leave a pair
  /// no room. Then the step must be shortened, and `failure_reason` names the jammed group and its
  /// anchors.
  bool apply(std::span<Vec3> x_t1);

  /// The groups of all pairs so far.
  const ContactGroups& groups() const { return groups_; }
  /// Why the last `apply` returned false.
  const std::string& failure_reason() const { return failure_reason_; }

 private:
  struct HalfSpace {  // normal·δ >= bound, bound <= 0
    std::int32_t particle;
    Vec3 normal;
    double bound, slack;  // m; slack: how far rounding may exceed the bound
    double friction;
  };

  void make_references(std::span<const Vec3> x_t1);
  Vec3 beyond(std::int32_t i, const ReferenceMotion& reference, const Mat3& inverse,
              std::span<const Vec3> x_t1) const;
  bool cut(const ContactPoint& pair, std::span<const Vec3> x_t1);
  void clip(std::span<const HalfSpace> planes, Vec3& delta);
  void clip();
  void keep_followers(std::span<const Vec3> x_t1);
  void write(std::span<Vec3> x_t1);

  ResponseStep step_;
  ContactGroups groups_;
  std::vector<ContactPoint> pairs_;
  std::optional<Vec3> shift_;
  std::vector<Vec3> desired_;  // x_t1 of the particles at begin
  std::vector<Vec3> delta_;    // m, displacement beyond the reference motion, in its frame; for
                               // particles in groups
  std::vector<ReferenceMotion> references_;
  std::vector<Mat3> inverse_;  // of I + turn
  std::vector<HalfSpace> half_spaces_;
  std::vector<double> multiplier_;
  std::string failure_reason_;
};

}  // namespace selvedge::detail
