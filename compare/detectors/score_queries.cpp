// SPDX-License-Identifier: MIT
#include <selvedge/compare/detectors/compare_detectors.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/narrowphase/ccd_methods.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace selvedge {
namespace {

using Clock = std::chrono::steady_clock;

/// Shortest timed span: a thousand times the cost of reading the clock.
constexpr double kSpan_s = 50e-6;
/// A query that takes at least this long is timed alone; reading the clock costs a thousandth of
/// it.
constexpr double kSlow_s = 50e-6;
/// Passes and repeats of slow methods stop after this time, after at least two of each.
constexpr double kPassBudget_s = 2.0, kQueryBudget_s = 0.05;
constexpr std::size_t kCopies = 32;
constexpr double kMicro = 1e6;

template <class Call>
double seconds_of(const Call& call) {
  const Clock::time_point begin = Clock::now();
  call();
  return seconds_since(begin);
}

/// The later of two neighbouring doubles cannot be the true time; otherwise both would be equal.
bool is_late(double toi, const TimeEnclosure& truth) {
  return std::nextafter(truth.lo, 2.0) >= truth.hi ? toi > truth.lo : toi > truth.hi;
}

double error_of(double toi, const TimeEnclosure& truth) {
  return std::max({0.0, truth.lo - toi, toi - truth.hi});
}

void judge_time(double toi, const TimeEnclosure& truth, QueryScore& score) {
  if (truth.lo == kNoCollision) return;
  *score.late_toi += is_late(toi, truth) ? 1 : 0;
  score.max_toi_error = std::max(*score.max_toi_error, error_of(toi, truth));
}

QueryScore judge(const QuerySet& set, std::span<const double> toi, bool gives_time) {
  QueryScore score;
  score.queries = toi.size();
  if (gives_time) {
    score.late_toi = 0;
    score.max_toi_error = 0.0;
  }
  for (std::size_t i = 0; i < toi.size(); ++i) {
    const bool truth = set.truth[i] != 0, found = toi[i] != kNoCollision;
    score.positives += truth ? 1 : 0;
    if (truth && !found && score.misses++ == 0) score.first_miss = i;
    if (!truth && found && score.false_alarms++ == 0) score.first_false_alarm = i;
    if (truth && found && gives_time && !set.toi.empty()) judge_time(toi[i], set.toi[i], score);
  }
  return score;
}

class QueryTimer {
 public:
  QueryTimer(const NarrowPhase& method, int repeats) : method_(method), repeats_(repeats) {}

  /// Seconds a query, in calls with all queries.
  double mean_of(std::span<const Query> queries, std::span<double> toi, double first_pass) {
    const double n = static_cast<double>(queries.size());
    if (first_pass > kPassBudget_s) return first_pass / n;
    const auto calls = static_cast<std::size_t>(std::ceil(kSpan_s / std::max(first_pass, 1e-9)));
    const double least = least_of(kPassBudget_s, [&] {
      for (std::size_t c = 0; c < calls; ++c) method_.find_times(queries, toi);
    });
    return least / (n * static_cast<double>(calls));
  }

  /// Seconds of one query.
  double time_of(const Query& query) {
    std::fill(std::begin(copies_), std::end(copies_), query);
    double least = repeat(1);
    if (least < kSlow_s) least = repeat(kCopies);
    return least;
  }

 private:
  double repeat(std::size_t copies) {
    const std::span<const Query> queries = std::span(copies_).first(copies);
    const std::span<double> toi = std::span(toi_).first(copies);
    const auto call = [&] { method_.find_times(queries, toi); };
    return least_of(kQueryBudget_s, call) / static_cast<double>(copies);
  }

  /// Seconds of the fastest, uninterrupted repeat.
  template <class Call>
  double least_of(double budget_s, const Call& call) const {
    double least = std::numeric_limits<double>::infinity(), spent = 0.0;
    for (int r = 0; r < repeats_ && (r < 2 || spent < budget_s); ++r) {
      const double s = seconds_of(call);
      spent += s;
      least = std::min(least, s);
    }
    return least;
  }

  const NarrowPhase& method_;
  int repeats_;
  std::array<Query, kCopies> copies_;
  std::array<double, kCopies> toi_;
};

void time_queries(const NarrowPhase& method, const QuerySet& set, int repeats, double first_pass,
                  QueryScore& score) {
  QueryTimer watch(method, repeats);
  std::vector<double> toi(set.queries.size()), seconds(set.queries.size());
  score.mean_us = kMicro * watch.mean_of(set.queries, toi, first_pass);
  for (std::size_t i = 0; i < seconds.size(); ++i) seconds[i] = watch.time_of(set.queries[i]);
  const auto slowest = std::max_element(seconds.begin(), seconds.end());
  score.slowest = static_cast<std::size_t>(slowest - seconds.begin());
  std::sort(seconds.begin(), seconds.end());
  const auto rank = [&](double share) {
    const auto last = static_cast<double>(seconds.size());
    return kMicro * seconds[static_cast<std::size_t>(std::ceil(share * last)) - 1];
  };
  score.median_us = rank(0.5);
  score.p99_us = rank(0.99);
  score.max_us = rank(1.0);
}

}  // namespace

bool complete_times(QuerySet& set) {
  set.toi.resize(set.queries.size());
  std::vector<std::size_t> unknown;
  for (std::size_t i = 0; i < set.toi.size(); ++i)
    if (set.truth[i] != 0 && set.toi[i].lo == kNoCollision) unknown.push_back(i);
  const std::unique_ptr<NarrowPhase> exact = make_ccd_exact();
  for (const std::size_t i : unknown) {
    double toi = kNoCollision;
    if (exact->collides(set.queries[i], toi))
      set.toi[i] = {toi, std::min(1.0, std::nextafter(toi, 2.0))};
  }
  return !unknown.empty();
}

QueryScore score_queries(const NarrowPhase& method, const QuerySet& set, int repeats) {
  std::vector<double> toi(set.queries.size());
  const auto pass = [&] { method.find_times(set.queries, toi); };
  double first_pass = seconds_of(pass);
  if (repeats > 0 && first_pass < kPassBudget_s)
    first_pass = seconds_of(pass);  // caches are warm now
  QueryScore score = judge(set, toi, method.traits().gives_time);
  if (repeats > 0) time_queries(method, set, repeats, first_pass, score);
  return score;
}

}  // namespace selvedge
