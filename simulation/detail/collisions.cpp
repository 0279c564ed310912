// SPDX-License-Identifier: MIT
#include <selvedge/simulation/detail/collisions.h>

#include <algorithm>

namespace selvedge {

void Collisions::find(const SearchContext& context, const Candidates& candidates,
                      const Contacts& contacts, std::vector<ContactPoint>& out) {
  const auto scope = context.clock.measure("narrow_phase");
  out.clear();
  timed_.clear();
  const SurfaceView cloth = context.motion.cloth(0.0), body = context.motion.bodies(0.0);
  if (const CandidatePairs* pairs = candidates.with_bodies()) {
    const PhaseClock::Scope busy(context.plan.busy_bodies());
    narrow_->find_contacts(cloth, body, *pairs, found_);
    for (const Contact& c : found_) timed_.emplace_back(c.toi, contacts.joint(c, false));
  }
  if (const CandidatePairs* pairs = candidates.with_self()) {
    const PhaseClock::Scope busy(context.plan.busy_self());
    narrow_->find_contacts(cloth, cloth, *pairs, found_);
    for (const Contact& c : found_) timed_.emplace_back(c.toi, contacts.joint(c, true));
  }
  std::stable_sort(timed_.begin(), timed_.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [toi, c] : timed_) out.push_back(c);
}

}  // namespace selvedge
