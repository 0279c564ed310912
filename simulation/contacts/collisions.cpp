// SPDX-License-Identifier: MIT
#include <selvedge/simulation/contacts/detail/collisions.h>

#include <algorithm>

namespace selvedge::detail {

// Pairs that are proved not to collide are left out, unless the method raises false alarms, which
// are part of its result.
void Collisions::append(const SearchContext& context, Candidates& candidates,
                        const Contacts& contacts, bool self) {
  const CandidatePairs* pairs = self ? candidates.with_self() : candidates.with_bodies();
  if (pairs == nullptr) return;
  const PhaseClock::Scope busy(self ? context.plan.busy_self() : context.plan.busy_bodies());
  const SurfaceView cloth = context.motion.cloth(0.0), body = context.motion.bodies(0.0);
  const SurfaceView& other = self ? cloth : body;
  const NarrowPhaseTraits traits = narrow_->traits();
  if (traits.misses_nothing && traits.no_false_alarm)
    pairs = &candidates.certificates().open(self, cloth, other, *pairs);
  if (pairs->size() == 0) return;
  narrow_->find_contacts(cloth, other, *pairs, found_);
  for (const Contact& c : found_) timed_.emplace_back(c.toi, contacts.joint(c, self));
}

void Collisions::find(const SearchContext& context, Candidates& candidates,
                      const Contacts& contacts, std::vector<ContactPoint>& out) {
  const auto scope = context.clock.measure("collision");
  out.clear();
  timed_.clear();
  candidates.certificates().measure(context.motion.x_t1(), context.motion.particles());
  append(context, candidates, contacts, false);
  append(context, candidates, contacts, true);
  std::stable_sort(timed_.begin(), timed_.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [toi, c] : timed_) out.push_back(c);
}

}  // namespace selvedge::detail
