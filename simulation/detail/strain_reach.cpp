// SPDX-License-Identifier: MIT
#include <selvedge/simulation/detail/strain_reach.h>

#include <algorithm>
#include <limits>

namespace selvedge::detail {
namespace {

/// Roundings of a strain, in units of the last place of its coordinates: differences, norm,
/// quotient, and those of the bound itself, with a reserve.
constexpr double kRoundings = 64.0;

}  // namespace

StrainReach::StrainReach(bool on, const StrainLimiter& measure) : on_(on) {
  shortest_ = std::numeric_limits<double>::infinity();
  for (const Spring& s : measure.springs()) shortest_ = std::min(shortest_, s.rest_length);
}

StrainReport StrainReach::measure(const StrainLimiter& measure, std::span<const Vec3> x) {
  const StrainReport report = measure.measure(x);
  if (!on_) return report;
  measured_.assign(x.begin(), x.end());
  report_ = report;
  return report;
}

/// Upper bound of the change of a strain since the measure.
double StrainReach::change(std::span<const Vec3> x) const {
  const double infinite = std::numeric_limits<double>::infinity();
  Vec3 low = Vec3::Constant(infinite), high = -low, size = Vec3::Zero();
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 moved = x[i] - measured_[i];
    low = low.cwiseMin(moved);
    high = high.cwiseMax(moved);
    size = size.cwiseMax(x[i].cwiseAbs()).cwiseMax(measured_[i].cwiseAbs());
  }
  const double rounding =
      kRoundings * std::numeric_limits<double>::epsilon() * (size.maxCoeff() + shortest_);
  return ((high - low).norm() + rounding) / shortest_;
}

bool StrainReach::keeps_below(std::span<const Vec3> x, double max_strain, double excess) {
  if (!on_ || measured_.size() != x.size()) return false;
  if (report_.max_strain > max_strain || report_.excess > excess || !measures_.is_due())
    return false;
  const double more = change(x);
  const bool proved = report_.max_strain + more <= max_strain && report_.excess + more <= excess;
  measures_.note(proved);
  return proved;
}

bool StrainReach::keeps_limits(std::span<const Vec3> x, LimitedStrain limits) {
  ++count_.asked;
  if (!on_ || limits == LimitedStrain::any || measured_.size() != x.size()) return false;
  const double excess = limits == LimitedStrain::stretch
                            ? report_.excess
                            : std::max(report_.excess, report_.compression_excess);
  if (excess > 0.0 || !limits_.is_due()) return false;
  const bool proved = excess + change(x) <= 0.0;
  limits_.note(proved);
  if (proved) ++count_.idle;
  return proved;
}

}  // namespace selvedge::detail
