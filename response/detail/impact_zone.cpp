// SPDX-License-Identifier: MIT
#include <selvedge/response/detail/impact_zone.h>
#include <selvedge/response/detail/reference_motion.h>

#include <algorithm>

namespace selvedge::detail {

void ImpactZones::begin(const ContactMotion& motion) {
  motion_ = motion;
  groups_.begin(motion);
  failure_reason_.clear();
}

void ImpactZones::merge(std::span<const ContactPoint> contacts) { groups_.merge(contacts); }

bool ImpactZones::grow(std::span<const ContactPoint> contacts, std::span<const double> mass,
                       std::span<Vec3> x_t1, std::map<std::string, double>& counters) {
  merge(contacts);
  counters["zone_rounds"] += 1;
  double& largest = counters["max_zone"];
  largest = std::max(largest, static_cast<double>(members()));
  return apply(mass, x_t1);
}

bool ImpactZones::apply(std::span<const double> mass, std::span<Vec3> x_t1) {
  failure_reason_.clear();
  for (const ContactGroup& zone : groups_.groups()) {
    const bool free = zone.anchors.empty();
    const ReferenceMotion motion = free ? momentum_motion(zone.particles, mass, motion_.x_t0, x_t1)
                                        : anchor_motion(zone.anchors, motion_.x_t0, x_t1);
    if (free && angle_of(motion) > kMaxTurn)
      failure_reason_ = "an impact zone of " + std::to_string(zone.particles.size()) +
                        " particles rotates too far to move as one piece";
    else if (!free && motion.residual > kRigidResidual)
      failure_reason_ = jam_sentence(zone, motion_, x_t1);
    for (const std::int32_t i : zone.particles)
      x_t1[i] = motion_.x_t0[i] + motion.displacement(motion_.x_t0[i]);
  }
  return failure_reason_.empty();
}

}  // namespace selvedge::detail
