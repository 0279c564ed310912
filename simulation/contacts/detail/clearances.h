// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/fail_safe.h>
#include <selvedge/simulation/contacts/detail/contacts.h>

#include <vector>

namespace selvedge::detail {

/// Answers the fail-safe for a scene: how far pairs are apart at the start of a step, and which
/// pairs can meet.
class SceneClearances final : public Clearances {
 public:
  /// All must outlive it; `broad` must be conservative.
  SceneClearances(const SearchContext& context, const Candidates& candidates,
                  const Contacts& contacts, BroadPhase& broad)
      : context_(context), candidates_(candidates), contacts_(contacts), broad_(broad) {}

  void at_start(std::span<const ContactPoint> hits, std::vector<ContactPoint>& out) override;
  void all(const Vec3& shift, std::vector<ContactPoint>& out) override;

 private:
  const SearchContext& context_;
  const Candidates& candidates_;
  const Contacts& contacts_;
  BroadPhase& broad_;
  std::vector<Contact> found_;
};

}  // namespace selvedge::detail
