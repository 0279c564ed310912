// SPDX-License-Identifier: MIT
#include <selvedge/response/detail/impulse.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

void move(const ContactPoint& c, const ContactMotion& motion, const Vec3& impulse,
          std::span<Vec3> x_t1) {
  for (int k = 0; k < 4; ++k) {
    const double w = motion.inv_mass[c.vertex[k]];
    if (w > 0.0) x_t1[c.vertex[k]] += c.weight[k] * w * impulse;
  }
}

void apply(const ContactMotion& motion, const ContactPoint& c, const ImpulseConfig& config,
           std::span<Vec3> x_t1) {
  const double wanted =
      std::min(config.end_gap, std::max(c.gap, 0.0) / c.rest_gap + config.recovery);
  const double violation = wanted * c.rest_gap - c.normal.dot(relative(c, x_t1));
  const double compliance_c = compliance(c, motion.inv_mass);
  if (violation <= 0.0 || compliance_c <= 0.0) return;
  move(c, motion, violation / compliance_c * c.normal, x_t1);
  if (c.friction <= 0.0) return;
  const Vec3 u = relative(c, x_t1) - relative(c, motion.x_t0);
  const Vec3 slip = u - c.normal.dot(u) * c.normal;
  const double distance = slip.norm();
  // [Bridson2002] friction equation: |Δv_t| = min(μ Δv_n, |v_t|).
  if (distance > 0.0)
    move(c, motion, -std::min(c.friction * violation / distance, 1.0) / compliance_c * slip, x_t1);
}

}  // namespace

void apply_impulses(const ContactMotion& motion, std::span<const ContactPoint> contacts,
                    const ImpulseConfig& config, std::span<Vec3> x_t1) {
  for (int sweep = 0; sweep < config.sweeps; ++sweep)
    for (const ContactPoint& c : contacts) apply(motion, c, config, x_t1);
}

}  // namespace selvedge::detail
