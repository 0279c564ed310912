// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/detail/contact_geometry.h>
#include <selvedge/narrowphase/narrow_phase.h>

#include <concepts>
#include <memory>
#include <utility>

namespace selvedge::detail {

/// A rule decides one query with finite coordinates: it returns the time of contact, or
/// kNoCollision.
template <class Rule>
concept QueryRule = requires(const Rule& rule, const Query& query) {
  { rule.time(query) } -> std::same_as<double>;
  { rule.traits() } -> std::same_as<NarrowPhaseTraits>;
};

/// A narrow phase that applies a rule to each query.
template <QueryRule Rule>
class PerQuery final : public NarrowPhase {
 public:
  explicit PerQuery(Rule rule) : rule_(std::move(rule)) {}

  void find_times(std::span<const Query> queries, std::span<double> toi) const override {
    for (std::size_t i = 0; i < queries.size(); ++i) {
      require_finite(queries[i]);
      toi[i] = rule_.time(queries[i]);
    }
  }
  NarrowPhaseTraits traits() const override { return rule_.traits(); }

 private:
  Rule rule_;
};

template <QueryRule Rule>
std::unique_ptr<NarrowPhase> per_query(Rule rule) {
  return std::make_unique<PerQuery<Rule>>(std::move(rule));
}

}  // namespace selvedge::detail
