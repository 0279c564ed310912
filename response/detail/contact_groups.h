// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/response.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// Particles that contacts connect, directly or through other particles.
struct ContactGroup {
  std::vector<std::int32_t> particles;  ///< free particles, ascending
  std::vector<std::int32_t> anchors;    ///< body vertices and held particles that they meet,
                                        ///< ascending
};

/// The groups of particles that the contacts of a step connect. Groups only grow. Anchors connect
/// nothing: two pieces of cloth on one body remain two groups.
class ContactGroups {
 public:
  /// Discards the groups of the previous step.
  void begin(const ContactMotion& motion);
  /// Joins the particles of each contact, with those that lead or follow them. The result does not
  /// depend on the order of the contacts.
  void merge(std::span<const ContactPoint> contacts);

  /// The groups, ordered by their smallest particle.
  const std::vector<ContactGroup>& groups() const;
  /// Index in groups() of the group of a contact's free particles; -1 if it has no free particle.
  std::int32_t group_of(const ContactPoint& c) const;
  /// Whether a particle is in a group.
  bool contains(std::int32_t i) const;
  /// Number of particles that contacts name.
  std::size_t members() const;

 private:
  std::int32_t root(std::int32_t i) const;
  void unite(std::int32_t i, std::int32_t j);

  ContactMotion motion_;
  mutable std::vector<std::int32_t> parent_;  // union-find over particles
  std::vector<char> in_group_;                // contacts name it
  std::vector<char> bound_;  // it leads or follows another particle; empty: none does
  std::vector<std::array<std::int32_t, 2>> anchors_;  // (particle, anchor)
  mutable bool stale_ = true;                         // groups_ and index_ must be rebuilt
  mutable std::vector<ContactGroup> groups_;
  mutable std::vector<std::int32_t> index_;  // for each root, the index of its group
};

}  // namespace selvedge::detail
