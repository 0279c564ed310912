// SPDX-License-Identifier: MIT
#include <selvedge/simulation/detail/damped_steps.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

// Share of the rest gap that still cloth moves in a step, at most: 2.4 mm/s with 2 mm and 1/120 s.
constexpr double kAllButStill = 0.01;

}  // namespace

DampedSteps::DampedSteps(const Scene& scene, const BuiltScene& built)
    : rest_gap_(ContactPairs(scene).largest_rest_gap()) {
  for (const std::vector<Edge>& seam : built.seams)
    pairs_.insert(pairs_.end(), seam.begin(), seam.end());
}

bool DampedSteps::sews(std::span<const Vec3> x) const {
  double sum = 0.0;
  for (const auto& [a, b] : pairs_) sum += (x[a] - x[b]).norm();
  return sum > rest_gap_ * static_cast<double>(pairs_.size());
}

bool DampedSteps::is_still(std::span<const Vec3> v, double h) const {
  const double most = kAllButStill * rest_gap_ / h;
  Vec3 mean = Vec3::Zero();
  for (const Vec3& u : v) mean += u / static_cast<double>(v.size());
  return std::ranges::all_of(v,
                             [&](const Vec3& u) { return (u - mean).squaredNorm() < most * most; });
}

}  // namespace selvedge::detail
