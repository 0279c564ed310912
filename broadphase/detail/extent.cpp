// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/extent.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

constexpr std::size_t kSamples = 500;

template <class At>
Extent extent_of(std::size_t n, At at) {
  const std::size_t stride = n / kSamples + 1;
  Extent extent;
  std::vector<double> samples;
  for (int k = 0; n > 0 && k < 3; ++k) {
    samples.clear();
    for (std::size_t i = 0; i < n; i += stride) samples.push_back(at(i)[k]);
    const auto nth = [&](std::size_t place) {
      std::nth_element(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(place),
                       samples.end());
      return samples[place];
    };
    const double center = nth(samples.size() / 2);
    for (double& x : samples) x = std::abs(x - center);
    extent.center[k] = center;
    extent.size = std::max(extent.size, nth(samples.size() - 1 - samples.size() / 10));
  }
  return extent;
}

}  // namespace

Extent extent_of(std::span<const Vec3> x) {
  return extent_of(x.size(), [&](std::size_t i) -> const Vec3& { return x[i]; });
}

Extent rest_extent(const SurfaceView& body) {
  const Pose& pose = body.rigid->t0;
  const auto rest = [&](std::size_t i) -> Vec3 {
    return pose.rotation.transpose() * (body.x_t0[i] - pose.translation);
  };
  Extent extent = extent_of(body.x_t0.size(), rest);
  for (std::size_t i = 0; i < body.x_t0.size(); ++i)
    extent.reach = std::max(extent.reach, rest(i).cwiseAbs().sum());
  extent.reach += pose.translation.cwiseAbs().sum();
  return extent;
}

}  // namespace selvedge::detail
