// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/query_file.h>

#include <cstddef>
#include <optional>

namespace selvedge {

/// What a narrow phase makes of queries whose answers are known, and how long it takes.
struct QueryScore {
  std::size_t queries = 0, positives = 0;
  std::size_t misses = 0;                                    ///< collisions that it does not report
  std::size_t false_alarms = 0;                              ///< reports without a collision
  std::optional<std::size_t> first_miss, first_false_alarm;  ///< index of the query

  /// Of the collisions it finds, those whose time is later than the true one; none for a method
  /// that gives no time. Of times that neighbouring doubles enclose, the later one is late.
  std::optional<std::size_t> late_toi;
  std::optional<double> max_toi_error;  ///< largest distance from the enclosure, in steps

  /// Microseconds of one thread; none if no times were asked for.
  std::optional<double> mean_us, median_us, p99_us, max_us;
  std::optional<std::size_t> slowest;  ///< index of the query of max_us
};

/// Fills in the times of the collisions of which no file tells, as ccd_exact finds them. True if
/// there were any.
bool complete_times(QuerySet& set);

/// Verdicts and times of `method`. The mean is that of calls with all queries at once, warm.
/// Median, 99 % and maximum are over single queries: each is asked in calls with 32 copies of it,
/// slow ones alone. Of `repeats` of everything the least counts, so that neither the clock nor an
/// interruption does. Passes of more than two seconds are made once. 0 repeats: no times. Throws
/// what the method throws.
QueryScore score_queries(const NarrowPhase& method, const QuerySet& set, int repeats);

}  // namespace selvedge
