// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>

#include <algorithm>
#include <atomic>

namespace selvedge::detail {

/// Counts the pairs that all parts of a search find, against the budget of the call.
class PairTally {
 public:
  /// `bytes_per_pair`: the detector's peak memory per pair, including scratch and the capacity that
  /// growing lists reserve.
  PairTally(const PairBudget& budget, std::size_t bytes_per_pair)
      : budget_(budget), limit_(std::min(budget.pairs, budget.bytes / bytes_per_pair)) {}
  PairTally(const PairTally&) = delete;
  PairTally& operator=(const PairTally&) = delete;

  std::size_t limit() const { return limit_; }
  /// Adds the pairs found since the last call; throws BudgetExceeded if there are too many.
  /// Thread-safe. Call it before a list grows and once at its end.
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
