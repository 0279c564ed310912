// SPDX-License-Identifier: MIT
//
// What the errors of a comparison can tell apart.
#include <fmt/format.h>
#include <selvedge/compare/compare_table.h>
#include <selvedge/core/base/internal/text.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace selvedge {
namespace {

/// An error that was measured, and how far off it may be: half its interval.
struct MeasuredError {
  double value = 0.0, half = 0.0;
};

/// A size that makes sense: beyond it, no comparison will be repeated so often.
constexpr double kMostSeeds = 1e4;

std::vector<MeasuredError> errors_of(const CompareTable& table, bool above_uncertainty) {
  std::vector<MeasuredError> errors;
  for (const CompareRow& row : table.rows)
    if (row.status == RunStatus::ok && row.error && (!above_uncertainty || row.counts))
      errors.push_back({*row.error, std::max(row.error_half, table.uncertainty)});
  std::sort(errors.begin(), errors.end(),
            [](const MeasuredError& a, const MeasuredError& b) { return a.value < b.value; });
  return errors;
}

/// Groups from the smallest error on; each begins above all intervals of the group before.
std::size_t groups_of(const std::vector<MeasuredError>& errors) {
  std::size_t groups = 0;
  double reach = 0.0;
  for (const MeasuredError& e : errors) {
    if (groups == 0 || e.value - e.half > reach) {
      ++groups;
      reach = 0.0;
    }
    reach = std::max(reach, e.value + e.half);
  }
  return groups;
}

/// How large a comparison has to be so that an interval `half` becomes smaller than `wanted`.
std::string size_for(const CompareTable& table, double half, double wanted) {
  const double ratio = half / wanted;
  if (!std::isfinite(ratio)) return "no number of seeds could";
  if (!table.plan.limits.seeds || half <= table.uncertainty)
    return table.converges ? fmt::format("a reference {:.2g} times as accurate could", ratio)
                           : "no shorter step could, since the reference does not converge";
  const double seeds = std::ceil(table.plan.repeats * ratio * ratio);  // half ~ 1/√n
  if (!(seeds <= kMostSeeds)) return "no number of seeds within reason could";
  return fmt::format("about {:.0f} seeds could", std::max(seeds, table.plan.repeats + 1.0));
}

}  // namespace

std::string ranking(const CompareTable& table) {
  const std::vector<MeasuredError> all = errors_of(table, false), counting = errors_of(table, true);
  if (all.empty())
    return "Ranks no errors, since there is no reference: compares times, recall and differences "
           "from "
           "the first cell.";
  const std::string cells = counted(all.size(), "cell");
  if (counting.empty()) {
    const MeasuredError& worst = all.back();
    return fmt::format(
        "Ranks no errors: all of {} are within the scatter of the seeds or the uncertainty of the "
        "reference, {:.2g} {}; {}.",
        cells, worst.half, table.error_unit, size_for(table, worst.half, worst.value));
  }
  const std::size_t groups = groups_of(counting);
  const MeasuredError &first = counting.front(), &last = counting.back();
  if (groups < 2 && all.size() > 1)
    return fmt::format(
        "Ranks no errors: the intervals of {} of {} overlap, from {:.2g} to {:.2g} "
        "{}; {}.",
        counting.size(), cells, first.value, last.value, table.error_unit,
        size_for(table, first.half + last.half, last.value - first.value));
  return fmt::format("Ranks {} of {} by their errors, in {} whose intervals do not overlap.",
                     counting.size(), cells, counted(groups, "group"));
}

}  // namespace selvedge
