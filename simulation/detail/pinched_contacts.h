// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/response.h>

#include <span>
#include <vector>

namespace selvedge {

/// A pair that was found near, in the joint index space.
struct NearPair {
  ContactPoint contact;
  bool kept = false;  ///< it becomes a contact, unless another of its point replaces it
};

/// Straightens the contacts of pinched cloth. A cloth vertex is pinched if bodies on both sides of
/// the cloth are nearer to it than their rest gaps. Beside the rim of a jaw, the closest points of
/// the two jaws lie on the same side along the cloth: contacts along the distance would both push
/// the vertex out of the jaws, within the plane of the cloth, and stretch cloth that is held. In a
/// pinch, a contact acts across the cloth alone: it is the projection of a spring along the
/// distance on the normal N of the cloth. With w = |n·N| it keeps
///   n' = ±N, gap' = w gap, rest gap' = w rest gap,
/// so that equal pushes from both sides cancel, and what they press together is held by friction.
class PinchedContacts {
 public:
  PinchedContacts() = default;
  /// `cloth`: triangles of the cloth, of `particles` vertices.
  PinchedContacts(std::span<const Triangle> cloth, std::size_t particles)
      : cloth_(cloth), particles_(particles) {}

  /// Straightens the contacts of pinched cloth among `pairs` of the cloth with bodies: pairs of a
  /// point of the cloth first, sorted by that point. x: joint positions at the start of the step,
  /// m.
  void straighten(std::span<NearPair> pairs, std::span<const Vec3> x);

 private:
  void list_triangles();
  std::span<const std::int32_t> triangles_of(std::int32_t v) const;
  Vec3 normal_at(std::int32_t v, std::span<const Vec3> x) const;
  int side_of(const ContactPoint& c, std::span<const Vec3> x) const;
  void straighten_point(std::span<NearPair> group, std::span<const Vec3> x);
  void straighten_other(NearPair& pair, std::span<const Vec3> x) const;

  std::span<const Triangle> cloth_;
  std::size_t particles_ = 0;
  std::vector<std::size_t> begin_;     // of each particle in around_; empty until the first pinch
  std::vector<std::int32_t> around_;   // triangles of each particle
  std::vector<Vec3> normal_;           // of the cloth at pinched particles, else zero
  std::vector<std::int32_t> pinched_;  // particles with a normal
};

}  // namespace selvedge
