// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>

#include <algorithm>
#include <atomic>

namespace selvedge::detail {

/// Counts the pairs that the parts of a search find together, against the budget of the call.
class PairTally {
 public:
  /// `bytes_per_pair`: what the detector needs for one pair when it needs most, scratch and the
  /// room that growing lists hold in advance included.
  PairTally(const PairBudget& budget, std::size_t bytes_per_pair)
      : budget_(budget), limit_(std::min(budget.pairs, budget.bytes / bytes_per_pair)) {}
  PairTally(const PairTally&) = delete;
  PairTally& operator=(const PairTally&) = delete;

  std::size_t limit() const { return limit_; }
  /// Adds what was found since the last time; throws BudgetExceeded if that is too much. May be
  /// called by any thread. Call it before a list grows and once at its end.
  void add(std::size_t found) {
    const std::size_t total = count_.fetch_add(found, std::memory_order_relaxed) + found;
    if (total > limit_) throw BudgetExceeded(total, limit_, budget_);
  }

 private:
  PairBudget budget_;
  std::size_t limit_;
  std::atomic<std::size_t> count_{0};
};

}  // namespace selvedge::detail
