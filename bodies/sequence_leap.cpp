// SPDX-License-Identifier: MIT
#include <selvedge/bodies/internal/sequence_leap.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace selvedge {
namespace {

// Halfway between two frames, a body has at least this share of its size. A turn by 90 degrees
// leaves 0.82 of a ball (0.71 across the axis), vertices that change places by chance 0.71.
constexpr double kLeastMiddle = 0.75;

// A vertex leaps if each of its edges becomes this many times as long ...
constexpr double kEdgeGrowth = 4.0;
// ... and it moves by this share of the size of the body, apart from the motion of the whole.
constexpr double kLeastLeap = 0.1;

// Or the body keeps its size within this share, while its edges change by this share on average:
// in a coarse mesh every vertex is near every other one.
constexpr double kSameSize = 0.2, kEdgeChange = 0.3;

Vec3 mean_of(std::span<const Vec3> x) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : x) sum += p;
  return sum / static_cast<double>(std::max<std::size_t>(1, x.size()));
}

/// Root mean square distance from the mean.
double size_of(std::span<const Vec3> x) {
  const Vec3 mean = mean_of(x);
  double sum = 0.0;
  for (const Vec3& p : x) sum += (p - mean).squaredNorm();
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, x.size())));
}

std::size_t leaping(std::span<const Vec3> from, std::span<const Vec3> to,
                    std::span<const Edge> edges, double size) {
  std::vector<double> growth(from.size(), std::numeric_limits<double>::infinity());
  for (const Edge& e : edges) {
    const double before = (from[e[1]] - from[e[0]]).norm(), after = (to[e[1]] - to[e[0]]).norm();
    for (const std::int32_t v : e)
      growth[v] = std::min(growth[v], after / std::max(before, 1e-300));
  }
  const Vec3 moved = mean_of(to) - mean_of(from);
  std::size_t count = 0;
  for (std::size_t v = 0; v < from.size(); ++v)
    count += std::isfinite(growth[v]) && growth[v] > kEdgeGrowth &&
             (to[v] - from[v] - moved).norm() > kLeastLeap * size;
  return count;
}

/// Sum of the changes of the lengths of all edges, over the sum of their lengths.
double edge_change(std::span<const Vec3> from, std::span<const Vec3> to,
                   std::span<const Edge> edges) {
  double change = 0.0, length = 0.0;
  for (const Edge& e : edges) {
    const double before = (from[e[1]] - from[e[0]]).norm(), after = (to[e[1]] - to[e[0]]).norm();
    change += std::abs(after - before);
    length += before;
  }
  return length > 0.0 ? change / length : 0.0;
}

}  // namespace

std::string vertex_leap(std::span<const Vec3> from, std::span<const Vec3> to,
                        std::span<const Edge> edges) {
  const double size = std::min(size_of(from), size_of(to));
  if (from.size() != to.size() || !(size > 0.0)) return "";
  std::vector<Vec3> middle(from.size());
  for (std::size_t v = 0; v < from.size(); ++v) middle[v] = 0.5 * (from[v] + to[v]);
  const double left = size_of(middle) / size;
  const std::size_t leaps = leaping(from, to, edges, size);
  const std::string remedy =
      "; if they are numbered anew, export all files with the same order of vertices; if the body "
      "turns so fast, give more files a second";
  if (leaps > 0)
    return std::to_string(leaps) + " of " + std::to_string(from.size()) +
           " vertices leap away from their neighbours" + remedy;
  const bool torn = std::abs(size_of(to) / size_of(from) - 1.0) < kSameSize &&
                    edge_change(from, to, edges) > kEdgeChange;
  if (left < kLeastMiddle || torn)
    return "the vertices change places: halfway the body has " +
           std::to_string(static_cast<int>(std::lround(100.0 * left))) + " % of its size" + remedy;
  return "";
}

}  // namespace selvedge
