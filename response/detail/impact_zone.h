// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/detail/contact_groups.h>

#include <map>
#include <span>
#include <string>

namespace selvedge::detail {

/// Rigid impact zones [Provot1997; Bridson2002, section 7.5]: particles that still collide are
/// joined into zones, and each zone moves as one piece. Zones only grow within a step, so the
/// number of rounds is bounded, and nothing inside a zone can collide (reference_motion.h). A free
/// zone keeps its linear and angular momentum and never gains energy. A zone that touches body
/// vertices or held particles follows their motion; if they rest, it rests too, bit for bit.
/// Deviation: a free zone moves by the displacement of its rigid velocity instead of a rotation,
/// because only this keeps both momenta and the energy. Above kMaxTurn its stretch would be
/// visible, and the step must be shortened.
class ImpactZones {
 public:
  /// Largest rotation of a free zone in one step, radian; it stretches the zone by 4.4 %.
  static constexpr double kMaxTurn = 0.3;
  /// Maximum number of rounds of growing zones before the step is rejected.
  static constexpr int kRounds = 40;

  /// Starts a step and discards the zones of the previous one.
  void begin(const ContactMotion& motion);
  /// Joins the particles of each contact into one zone.
  void merge(std::span<const ContactPoint> contacts);
  /// Moves the particles of all zones; masses in kg, positions in m. Returns false if a free zone
  /// rotates by more than kMaxTurn, or a zone touches anchors that do not move as one rigid body.
  /// Then the step must be shortened, and `failure_reason` names the zone.
  bool apply(std::span<const double> mass, std::span<Vec3> x_t1);

  /// One round of growing: merges the contacts, then returns the result of `apply`. Counts the
  /// rounds ("zone_rounds") and the largest number of particles in zones ("max_zone").
  bool grow(std::span<const ContactPoint> contacts, std::span<const double> mass,
            std::span<Vec3> x_t1, std::map<std::string, double>& counters);

  /// Number of particles that are in a zone.
  std::size_t members() const { return groups_.members(); }
  /// Why the last `apply` returned false.
  const std::string& failure_reason() const { return failure_reason_; }

 private:
  ContactMotion motion_;
  ContactGroups groups_;
  std::string failure_reason_;
};

}  // namespace selvedge::detail
