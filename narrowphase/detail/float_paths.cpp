// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/narrowphase/detail/float_paths.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace selvedge::detail {
namespace {

constexpr std::size_t kVertexGrain = 2048;

/// The slack as a share of the largest coordinate; see FloatPaths.
constexpr double kSlack = 0x1p-20;
/// Metres: the least slack, and the largest coordinate for which anything is proved. In between, no
/// square of a difference overflows, and those that underflow are far below the slack.
constexpr double kLeastSlack = 1e-15, kMostExtent = 1e15;
/// Slacks of the length of a vector whose components are off by one slack (the distance of two
/// boxes) and by two (a relative displacement): more than sqrt(3) of each.
constexpr double kOfGap = 2.0, kOfSpread = 4.0;

/// Largest coordinate; NaN if one of them is not finite.
double largest_of(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1) {
  Vec3 largest = Vec3::Zero(), faults = Vec3::Zero();
  for (const auto x : {x_t0, x_t1})
    for (const Vec3& p : x) {
      largest = largest.cwiseMax(p.cwiseAbs());
      faults += p - p;  // 0 for finite p and NaN otherwise
    }
  return largest.maxCoeff() + faults.sum();
}

}  // namespace

FloatPaths::FloatPaths(const SurfaceView& a, const SurfaceView& b) {
  double largest = largest_coordinate(a, "a");
  if (&a != &b) largest = std::max(largest, largest_coordinate(b, "b"));
  const bool proves = largest <= kMostExtent;
  slack_ = proves ? static_cast<float>(std::max(kSlack * largest, kLeastSlack))
                  : std::numeric_limits<float>::infinity();
  own_a_ = convert(a, proves);
  if (&a != &b) own_b_ = convert(b, proves);
  paths_ = {own_a_.get(), &a != &b ? own_b_.get() : own_a_.get()};
}

void FloatPaths::take_block(const SurfacePairs& in, std::size_t begin, std::size_t end,
                            PairBlock& block) const {
  std::size_t n = 0;
  for (; n < block.pairs.size() && begin + n < end; ++n) {
    const PairVertices& pair = block.pairs[n] = pair_at(in.a, in.b, in.pairs, begin + n);
    if (pair.kind != block.pairs[0].kind) break;
    for (int k = 0; k < 4; ++k) {
      const int side = k < first_count(pair.kind) ? pair.first : pair.second;
      block.paths[k][n] = paths_[side][pair.vertex[k]].numbers.data();
    }
  }
  block.size = n;
  for (; n < block.pairs.size(); ++n)
    for (auto& paths : block.paths) paths[n] = paths[block.size - 1];
}

ScreenLimits FloatPaths::limits(double reach, double reach_at_start) const {
  constexpr double kRoundedUp = 1.0 + 0x1p-22;  // whatever the conversion to float rounds
  const double of_gap = kOfGap * slack_, of_spread = of_gap + kOfSpread * slack_;
  const auto up = [](double x) { return static_cast<float>(kRoundedUp * x); };
  return {.slack = slack_,
          .at_start = up(reach_at_start + of_gap),
          .with_motion = up(reach + of_spread),
          .lines = up(reach_at_start),
          .offset = slack_};
}

double FloatPaths::largest_coordinate(const SurfaceView& view, const char* name) {
  const std::size_t n = view.x_t0.size();
  std::vector<double> parts((n + kVertexGrain - 1) / kVertexGrain);
  parallel_for(n, kVertexGrain, [&](std::size_t begin, std::size_t end) {
    parts[begin / kVertexGrain] =
        largest_of(view.x_t0.subspan(begin, end - begin), view.x_t1.subspan(begin, end - begin));
  });
  double largest = 0.0;
  for (const double part : parts) {
    if (std::isnan(part)) require_finite(view, name);
    largest = std::max(largest, part);
  }
  return largest;
}

std::unique_ptr<FloatPaths::Path[]> FloatPaths::convert(const SurfaceView& view, bool proves) {
  const std::size_t n = view.x_t0.size();
  if (!proves) return std::make_unique<Path[]>(n);  // they do not fit into floats
  std::unique_ptr<Path[]> paths(new Path[n]);
  parallel_for(n, kVertexGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      paths[i].numbers[3] = paths[i].numbers[7] = 0.0F;
      for (std::size_t k = 0; k < 3; ++k) {
        paths[i].numbers[k] = static_cast<float>(view.x_t0[i][static_cast<int>(k)]);
        paths[i].numbers[4 + k] = static_cast<float>(view.x_t1[i][static_cast<int>(k)]);
      }
    }
  });
  return paths;
}

}  // namespace selvedge::detail
