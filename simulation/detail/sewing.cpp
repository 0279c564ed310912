// SPDX-License-Identifier: MIT
#include <selvedge/simulation/detail/sewing.h>

namespace selvedge::detail {

Sewing::Sewing(const Scene& scene, const BuiltScene& built)
    : closed_(ContactPairs(scene).largest_rest_gap()) {
  for (const std::vector<Edge>& seam : built.seams)
    pairs_.insert(pairs_.end(), seam.begin(), seam.end());
}

bool Sewing::goes_on(std::span<const Vec3> x) const {
  double sum = 0.0;
  for (const auto& [a, b] : pairs_) sum += (x[a] - x[b]).norm();
  return sum > closed_ * static_cast<double>(pairs_.size());
}

}  // namespace selvedge::detail
