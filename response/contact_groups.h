// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/contact_point.h>

#include <span>
#include <vector>

namespace selvedge {

/// Particles that contacts join, directly or through others.
struct ContactGroup {
  std::vector<std::int32_t> particles;  ///< free ones, ascending
  std::vector<std::int32_t> anchors;    ///< body vertices and held particles they meet, ascending
};

/// The groups that the contacts of a step make. They only grow. Anchors join nothing: two pieces of
/// cloth on one body stay two groups.
class ContactGroups {
 public:
  /// Forgets the groups of the step before.
  void begin(const ContactMotion& motion);
  /// Joins the particles of each contact. What comes out does not depend on their order.
  void merge(std::span<const ContactPoint> contacts);

  /// In the order of their smallest particle.
  const std::vector<ContactGroup>& groups() const;
  /// Which of groups() the free particles of a contact are in; -1: it has none.
  std::int32_t group_of(const ContactPoint& c) const;
  /// Particles that are in a group.
  std::size_t members() const;

 private:
  std::int32_t root(std::int32_t i) const;

  ContactMotion motion_;
  mutable std::vector<std::int32_t> parent_;  // union-find over particles
  std::vector<char> in_group_;
  std::vector<std::array<std::int32_t, 2>> anchors_;  // (particle, anchor)
  mutable bool stale_ = true;                         // groups_ and index_ have to be made anew
  mutable std::vector<ContactGroup> groups_;
  mutable std::vector<std::int32_t> index_;  // of the root's group
};

}  // namespace selvedge
