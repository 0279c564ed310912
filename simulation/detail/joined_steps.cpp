// SPDX-License-Identifier: MIT
#include <selvedge/simulation/detail/joined_steps.h>

#include <algorithm>
#include <cmath>

namespace selvedge::detail {
namespace {

// Contacts keep their stiffness in N/m, so that with three steps the system would be nine times as
// stiff, relative to the masses, as in one.
constexpr int kMostJoined = 2;

}  // namespace

JoinedSteps::JoinedSteps(const Scene& scene, const BuiltScene& built,
                         const IntegratorTraits& traits)
    : bound_(0.0),
      steps_per_frame_(scene.time.steps_per_frame),
      h_(1.0 / (scene.time.fps * scene.time.steps_per_frame)),
      piece_begin_(built.piece_begin),
      size_(piece_begin_.empty() ? 0 : piece_begin_.size() - 1, 0.0) {
  if (traits.order == 1 && traits.is_implicit && traits.any_step)
    bound_ = scene.time.step_error / (static_cast<double>(steps_per_frame_) * steps_per_frame_) /
             traits.share_of_euler_error;
  // Triangles of the rest shape correspond to those of the cloth. A triangle across a merged seam
  // counts for the piece of its first vertex.
  for (std::size_t i = 0; i < built.rest.triangles.size(); ++i) {
    const std::int32_t vertex = built.cloth.surface.triangles[i][0];
    const auto next = std::upper_bound(piece_begin_.begin(), piece_begin_.end(), vertex);
    const Triangle& t = built.rest.triangles[i];
    const Vec3& a = built.rest.vertices[t[0]];
    size_[static_cast<std::size_t>(next - piece_begin_.begin()) - 1] +=
        0.5 * (built.rest.vertices[t[1]] - a).cross(built.rest.vertices[t[2]] - a).norm();
  }
  for (double& size : size_) size = std::sqrt(size);
}

int JoinedSteps::span(std::int64_t done, double acceleration) const {
  if (!(bound_ > 0.0 && acceleration >= 0.0)) return 1;
  if (done % steps_per_frame_ == steps_per_frame_ - 1) return 1;  // the last one of its frame
  const double h = kMostJoined * h_;
  return 0.5 * h * h * acceleration <= bound_ ? kMostJoined : 1;
}

double JoinedSteps::acceleration(std::span<const Vec3> before, std::span<const Vec3> after,
                                 double h) const {
  if (!(bound_ > 0.0)) return -1.0;
  double largest = 0.0;
  for (std::size_t piece = 0; piece < size_.size(); ++piece) {
    const auto begin = static_cast<std::size_t>(piece_begin_[piece]);
    const auto end = static_cast<std::size_t>(piece_begin_[piece + 1]);
    if (begin == end) continue;
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i) sum += (after[i] - before[i]).squaredNorm();
    largest =
        std::max(largest, std::sqrt(sum / static_cast<double>(end - begin)) / (h * size_[piece]));
  }
  return std::isfinite(largest) ? largest : -1.0;
}

}  // namespace selvedge::detail
