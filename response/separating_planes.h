// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/clearances.h>
#include <selvedge/response/reference_motion.h>
#include <selvedge/response/response.h>

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// Planes between pairs. At x_t0 two primitives that do not touch lie on the two sides of a slab
/// (clearances.h). A vertex that is on its side at both ends of a straight path is there all the
/// time, since its height over the plane is linear in time; so are the convex hulls; so the pair
/// does not meet. The plane may move on a straight line as well, for in its frame paths stay
/// straight.
///
/// All planes of a group of particles move with one reference motion: that of the anchors if it has
/// any, else the mean one of its particles. Then "move as the reference does" satisfies all planes
/// at once, and what a particle wants beyond that, δ, is projected on the half-spaces of its own
/// planes: what is along them stays, but for the Coulomb friction of what the planes take. Where in
/// its slab a plane lies is chosen where the two sides would meet inelastically.
///
/// Guarantee, for reference motions that are translations: a pair that has a plane does not
/// collide. Since planes only accumulate and there are finitely many pairs, rounds end; with the
/// planes of Clearances::all, in one round. With anchors that turn the heights are not linear in
/// time, and the guarantee holds up to the square of the turn. Momentum of a group without anchors
/// is kept (a translation of the whole group, which its planes do not feel), and Σ m|d|² never
/// grows where anchors stand still or are absent. Angular momentum is not kept. Not for pairs that
/// have no room: touching at x_t0, or anchors that leave their slab, for which `apply` says so.
///
/// Source: that two convex sets which do not meet have a plane between them; reference motions,
/// offsets and friction are ours.
class SeparatingPlanes {
 public:
  /// `x_t1`: where the particles would end.
  void begin(const ResponseStep& step, std::span<const Vec3> x_t1);
  /// Pairs as Clearances gives them; those of earlier calls stay.
  void add(std::span<const ContactPoint> pairs);
  /// The one reference motion of all groups from now on: a translation, m.
  void fix_reference(const Vec3& shift) { shift_ = shift; }
  /// Writes where the particles of all pairs end. False if anchors leave a pair no room: then the
  /// step has to be shorter, and `trouble` tells whom they jam.
  bool apply(std::span<Vec3> x_t1);

  const ContactGroups& groups() const { return groups_; }
  const std::string& trouble() const { return trouble_; }

 private:
  struct HalfSpace {  // normal·δ >= bound, bound <= 0
    std::int32_t particle;
    Vec3 normal;
    double bound, slack;  // m; slack: how far rounding may go beyond
    double friction;
  };

  void make_references(std::span<const Vec3> x_t1);
  Vec3 beyond(std::int32_t i, const ReferenceMotion& reference, const Mat3& inverse,
              std::span<const Vec3> x_t1) const;
  bool cut(const ContactPoint& pair, std::span<const Vec3> x_t1);
  void clip(std::span<const HalfSpace> planes, Vec3& delta);
  void clip();
  void write(std::span<Vec3> x_t1);

  ResponseStep step_;
  ContactGroups groups_;
  std::vector<ContactPoint> pairs_;
  std::optional<Vec3> shift_;
  std::vector<Vec3> wish_;   // x_t1 that the particles had at begin
  std::vector<Vec3> delta_;  // of particles in groups: beyond the reference, in its frame
  std::vector<ReferenceMotion> references_;
  std::vector<Mat3> inverse_;  // of I + turn
  std::vector<HalfSpace> half_spaces_;
  std::vector<double> multiplier_;
  std::string trouble_;
};

}  // namespace selvedge
