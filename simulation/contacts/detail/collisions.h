// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/simulation/contacts/detail/contacts.h>

#include <memory>
#include <utility>
#include <vector>

namespace selvedge::detail {

/// The narrow phase of a scene: decides which candidates collide during the step.
class Collisions {
 public:
  explicit Collisions(std::unique_ptr<NarrowPhase> narrow) : narrow_(std::move(narrow)) {}

  /// The candidates that collide, earliest first; of equal times those with bodies first.
  void find(const SearchContext& context, Candidates& candidates, const Contacts& contacts,
            std::vector<ContactPoint>& out);

  NarrowPhaseTraits traits() const { return narrow_->traits(); }

 private:
  void append(const SearchContext& context, Candidates& candidates, const Contacts& contacts,
              bool self);

  std::unique_ptr<NarrowPhase> narrow_;
  std::vector<Contact> found_;
  std::vector<std::pair<double, ContactPoint>> timed_;  // time of impact in [0, 1]
};

}  // namespace selvedge::detail
