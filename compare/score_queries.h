// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/query_file.h>

#include <cstddef>
#include <optional>

namespace selvedge {

/// Accuracy and time of a narrow phase on queries with known answers.
struct QueryScore {
  std::size_t queries = 0, positives = 0;
  std::size_t misses = 0;                                    ///< collisions that it does not report
  std::size_t false_alarms = 0;                              ///< reports without a collision
  std::optional<std::size_t> first_miss, first_false_alarm;  ///< index of the query

  /// Number of detected collisions whose time is later than the true one; empty for a method that
  /// gives no time. If neighbouring doubles enclose the true time, the later double counts as late.
  std::optional<std::size_t> late_toi;
  std::optional<double> max_toi_error;  ///< largest distance from the enclosure, in steps

  /// Microseconds on one thread; empty if no times were requested.
  std::optional<double> mean_us, median_us, p99_us, max_us;
  std::optional<std::size_t> slowest;  ///< index of the query of max_us
};

/// Fills in missing collision times of the file by ccd_exact. Returns true if any were missing.
bool complete_times(QuerySet& set);

/// Verdicts and times of `method`. The mean covers warm calls with all queries at once. Median, 99
/// % and maximum are over single queries: each is measured in calls with 32 copies of it, and a
/// slow one in calls of its own. Each value is the minimum over `repeats`, which removes clock
/// noise and interruptions. A pass of more than two seconds is made once. With 0 repeats it
/// measures no times. Exceptions of the method propagate.
QueryScore score_queries(const NarrowPhase& method, const QuerySet& set, int repeats);

}  // namespace selvedge
