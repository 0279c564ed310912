// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/contact_point.h>

#include <span>
#include <vector>

namespace selvedge {

/// Rigid impact zones [Provot1997; Bridson2002, section 7.5], the fail-safe of a step: particles
/// that still collide are joined into zones, and each zone moves as one rigid body with its linear
/// and angular momentum. The straight paths x_t0 -> c + R(x_t0 - c) are one affine, invertible map
/// at every instant while the rotation is below half a turn, so that nothing inside a zone can
/// collide. A zone that touches body vertices or held particles follows them: without their motion
/// it stays where it is, bit for bit. Zones only grow within a step, so the number of rounds is
/// bounded.
class ImpactZones {
 public:
  /// Forgets the zones of the step before.
  void begin(const ContactMotion& motion);
  /// Joins the particles of each contact.
  void merge(std::span<const ContactPoint> contacts);
  /// Moves the members of all zones. False if a zone turns by half a turn or more, or touches parts
  /// that do not move as one rigid body: then the step has to be shorter.
  bool apply(std::span<const double> mass, std::span<Vec3> x_t1) const;

  /// Particles that are in a zone.
  std::size_t members() const;

 private:
  struct Zone {
    std::vector<std::int32_t> particles, anchors;  // anchors: body vertices and held particles
  };

  std::int32_t root(std::int32_t i) const;
  std::vector<Zone> zones() const;

  ContactMotion motion_;
  mutable std::vector<std::int32_t> parent_;  // union-find over particles
  std::vector<char> in_zone_;
  std::vector<std::array<std::int32_t, 2>> anchors_;  // (particle, anchor)
};

}  // namespace selvedge
