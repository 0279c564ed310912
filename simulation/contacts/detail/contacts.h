// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/build.h>
#include <selvedge/simulation/contacts/detail/candidates.h>
#include <selvedge/simulation/contacts/detail/contact_filter.h>
#include <selvedge/simulation/contacts/detail/surface_union.h>

#include <utility>
#include <vector>

namespace selvedge::detail {

/// A pair farther apart than this many rest gaps at the start of a step is left to the collision
/// test.
extern const double kProximityReach;
/// A point becomes a contact from this many rest gaps on.
extern const double kPointReach;

/// Makes the contacts of a scene: gives pairs of the narrow phase their rest gap and friction, and
/// thins out the pairs that are near, so that one contact carries each touch.
class Contacts {
 public:
  Contacts(const Scene& scene, const BuiltScene& built, const SceneMotion& motion);

  /// The length of the step of the motion, s.
  void set_step(double h);
  /// Pairs that are nearer at t = 0 than the distance that they have to keep, or would be at the
  /// end.
  void find_proximities(const SearchContext& context, Candidates& candidates,
                        std::vector<ContactPoint>& out);

  /// The same pair in the joint index space, with its gap at t = 0. `self`: both primitives are of
  /// the cloth.
  ContactPoint joint(const Contact& contact, bool self) const;
  /// The rest gap of the two surfaces of a contact, m.
  double pair_rest_gap(const ContactPoint& c) const;
  /// Coulomb coefficient of the two surfaces of a contact.
  double pair_friction(const ContactPoint& c) const;
  /// The largest rest gap of all surfaces, m.
  double largest_rest_gap() const;

 private:
  /// A found pair in the joint index space.
  struct Joined {
    ContactPoint contact;
    bool kept = false;  ///< it becomes a contact, unless another of its point replaces it
  };

  std::pair<std::int32_t, std::int32_t> surfaces(const ContactPoint& c) const;
  double rest_gap(const ContactPoint& c, bool self) const;
  bool is_near(const Contact& contact, const ContactPoint& c) const;
  bool is_contact(const Contact& contact, const ContactPoint& c) const;
  void turn_at_hem(ContactPoint& c) const;
  void turn_along_way(std::size_t found, ContactPoint& c) const;
  void for_each_of_point(std::size_t found, auto&& visit) const;
  void append_proximities(bool self, std::vector<ContactPoint>& out);
  void drop_walls(bool self);
  bool is_wall(bool self, ContactPoint& c) const;
  void append_particles(std::span<const ParticleContact> contacts, std::vector<ContactPoint>& out);
  void append_group(std::vector<ContactPoint>& out);

  const SceneMotion& motion_;
  ContactPairs pairs_;
  Vec3 gravity_, fall_ = Vec3::Zero();  // m/s²; m, by gravity in the step
  ContactFilter filter_;
  SurfaceUnion bodies_, cloth_;              // each as one surface
  std::uint64_t fitted_ = 0;                 // where the bodies were when their union was fitted
  std::vector<Vec3> rest_;                   // cloth at the start
  std::vector<std::int32_t> surface_;        // of each joint vertex, as ContactPairs counts
  std::vector<char> border_;                 // of each cloth vertex: on an edge with one triangle
  std::vector<std::vector<char>> collides_;  // by piece and surface; empty: all do
  std::vector<Contact> found_;
  std::vector<Joined> joined_;       // of found_
  std::vector<ContactPoint> group_;  // contacts of one point, before they are thinned out
};

}  // namespace selvedge::detail
