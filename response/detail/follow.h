// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/response.h>

#include <algorithm>
#include <span>

namespace selvedge::detail {

/// Rounds in which leaders are shortened by as little as it takes; from then on they stop.
inline constexpr int kFollowRounds = 32;

/// Restores δ_i = Σ w δ_leader for followers by shortening the δ of leaders. `share(i, δ)` is the
/// largest s in [0, 1] with which s·δ is allowed for follower i; 0 is allowed for everything, and
/// what is allowed for a leader stays so if it is shorter. So it ends. A held leader keeps its δ.
template <class Share>
void follow(const ContactMotion& motion, std::span<Vec3> delta, const Share& share) {
  if (motion.followers == nullptr) return;
  const Followers& followers = *motion.followers;
  for (bool settled = false, stops = false; !settled;) {
    for (int round = 0; round < kFollowRounds && !settled; ++round) {
      settled = true;
      for (const std::int32_t i : followers.nodes()) {
        if (motion.inv_mass[i] <= 0.0) continue;
        Vec3 mean = Vec3::Zero();
        for (const Followers::Share& s : followers.shares(i))
          mean += s.weight * delta[followers.leaders()[s.leader]];
        const double part = share(i, mean);
        delta[i] = mean;
        if (part >= 1.0) continue;
        for (const Followers::Share& s : followers.shares(i)) {
          const std::int32_t leader = followers.leaders()[s.leader];
          if (motion.inv_mass[leader] <= 0.0 || delta[leader].isZero(0.0)) continue;
          delta[leader] *= stops ? 0.0 : part;
          settled = false;
        }
      }
    }
    stops = true;
  }
}

}  // namespace selvedge::detail
