// SPDX-License-Identifier: MIT
//
// Contacts with vertices of rigid bodies, which follow four particles each.
#pragma once

#include <selvedge/response/response.h>

#include <utility>
#include <vector>

namespace selvedge::detail {

/// Calls body(i, weight) for each particle that a contact moves: its own or, for a vertex of a
/// rigid body, those that it follows. Particles may come several times.
template <class Body>
void for_each_mover(const ContactPoint& c, const ContactMotion& motion, const Body& body) {
  const Followers* followers = motion.followers;
  for (int k = 0; k < 4; ++k) {
    const auto i = static_cast<std::size_t>(c.vertex[k]);
    if (i >= motion.particles) continue;
    if (followers == nullptr || !followers->has_rigid()) {
      body(i, c.weight[k]);
      continue;
    }
    for (const Followers::Share& s : followers->shares(i))
      body(static_cast<std::size_t>(followers->leaders()[s.leader]), c.weight[k] * s.weight);
  }
}

/// As compliance(), with the corners of one rigid body taken together.
inline double true_compliance(const ContactPoint& c, const ContactMotion& motion) {
  if (motion.followers == nullptr || !motion.followers->has_rigid())
    return compliance(c, motion.inv_mass);
  std::vector<std::pair<std::size_t, double>> movers;
  for_each_mover(c, motion, [&](std::size_t i, double weight) {
    for (auto& [mover, sum] : movers)
      if (mover == i) {
        sum += weight;
        return;
      }
    movers.emplace_back(i, weight);
  });
  double all = 0.0;
  for (const auto& [i, weight] : movers) all += weight * weight * motion.inv_mass[i];
  return all;
}

}  // namespace selvedge::detail
