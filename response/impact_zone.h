// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/contact_groups.h>

#include <map>
#include <span>
#include <string>

namespace selvedge {

/// Rigid impact zones [Provot1997; Bridson2002, section 7.5]: particles that still collide are
/// joined into zones, and each zone moves as one piece. Zones only grow within a step, so that the
/// number of rounds is bounded, and nothing inside a zone can collide (reference_motion.h). A free
/// zone keeps its linear and angular momentum and never gains energy. A zone that touches body
/// vertices or held particles follows them: without their motion it stays where it is, bit for bit.
/// Deviation: a free zone's displacement is that of its rigid velocity instead of a rotation, for
/// only this keeps both momenta and the energy; above kMaxTurn its stretch would be seen, and the
/// step has to be shorter.
class ImpactZones {
 public:
  /// Largest turn of a zone in one step, radian: it stretches a free zone by 4.4 %.
  static constexpr double kMaxTurn = 0.3;
  /// Rounds of growing zones before a step is given up.
  static constexpr int rounds = 40;

  /// Forgets the zones of the step before.
  void begin(const ContactMotion& motion);
  /// Joins the particles of each contact.
  void merge(std::span<const ContactPoint> contacts);
  /// Moves the members of all zones. False if a free zone turns by more than kMaxTurn, or a zone
  /// touches parts that do not move as one rigid body: then the step has to be shorter, and
  /// `trouble` tells which zone it was.
  bool apply(std::span<const double> mass, std::span<Vec3> x_t1);

  /// One round of growing: merge, then apply, whose answer it returns. Counts the rounds
  /// ("zone_rounds") and the most particles in zones ("max_zone").
  bool grow(std::span<const ContactPoint> contacts, std::span<const double> mass,
            std::span<Vec3> x_t1, std::map<std::string, double>& counters);

  /// Particles that are in a zone.
  std::size_t members() const { return groups_.members(); }
  const std::string& trouble() const { return trouble_; }

 private:
  ContactMotion motion_;
  ContactGroups groups_;
  std::string trouble_;
};

}  // namespace selvedge
