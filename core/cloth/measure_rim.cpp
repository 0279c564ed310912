// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/measure.h>

#include <algorithm>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>

namespace selvedge {
namespace {

/// From each boundary vertex to the next one, in the direction of the triangles.
std::multimap<std::int32_t, std::int32_t> boundary_steps(std::span<const Triangle> triangles) {
  std::map<Edge, int> uses;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = t[k], b = t[(k + 1) % 3];
      ++uses[{std::min(a, b), std::max(a, b)}];
    }
  std::multimap<std::int32_t, std::int32_t> steps;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = t[k], b = t[(k + 1) % 3];
      if (uses[{std::min(a, b), std::max(a, b)}] == 1) steps.emplace(a, b);
    }
  return steps;
}

double length_of(std::span<const Vec3> x, const std::vector<std::int32_t>& loop) {
  double length = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    length += (x[loop[(i + 1) % loop.size()]] - x[loop[i]]).norm();
  return length;
}

/// A sample of the rim; empty if the rim has no point in this direction.
struct RimPoint {
  double radius = -1.0, height = 0.0;
};

RimPoint outermost(std::span<const Vec3> x, const std::vector<std::int32_t>& rim,
                   const Vec3& centre, double angle) {
  const double c = elementary::cos(angle), s = elementary::sin(angle);
  RimPoint best;
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const Vec3 p = x[rim[i]] - centre, q = x[rim[(i + 1) % rim.size()]] - centre;
    const double side_p = c * p.y() - s * p.x(), side_q = c * q.y() - s * q.x();
    if ((side_p < 0.0) == (side_q < 0.0)) continue;
    const double t = side_p / (side_p - side_q);
    const Vec3 at = p + t * (q - p);
    const double radius = c * at.x() + s * at.y();
    if (radius > best.radius) best = {radius, at.z() + centre.z()};
  }
  return best;
}

std::vector<double> spectrum_of(const std::vector<double>& values) {
  const auto n = static_cast<int>(values.size());
  std::vector<double> amplitude;
  for (int order = 0; order <= n / 2; ++order) {
    double cosine = 0.0, sine = 0.0;
    for (int k = 0; k < n; ++k) {
      // The product is reduced modulo n so that the angle keeps its precision.
      const double angle = 2.0 * std::numbers::pi * ((std::int64_t{order} * k) % n) / n;
      cosine += values[k] * elementary::cos(angle);
      sine += values[k] * elementary::sin(angle);
    }
    const bool single = order == 0 || 2 * order == n;
    amplitude.push_back((single ? 1.0 : 2.0) * elementary::hypot(cosine, sine) / n);
  }
  return amplitude;
}

/// Maxima around a circle with at least `prominence` between them and the next higher one.
int count_maxima(const std::vector<double>& r, double prominence) {
  const std::size_t n = r.size(), first = std::max_element(r.begin(), r.end()) - r.begin();
  int count = 0;
  bool rising = false;
  double low = r[first], high = r[first];
  for (std::size_t k = 1; k <= n; ++k) {
    const double value = r[(first + k) % n];
    if (rising) {
      high = std::max(high, value);
      if (high - value > prominence || k == n) {
        ++count;
        rising = false;
        low = value;
      }
    } else {
      low = std::min(low, value);
      if (value - low > prominence) {
        rising = true;
        high = value;
        if (k == n) ++count;
      }
    }
  }
  return count;
}

constexpr double kRoundRim =
    1e-9;  // relative amplitude below which the rim is round and has no folds

int strongest_order(const std::vector<double>& amplitude) {
  constexpr std::size_t first = 2;  // order 1 is an off-centre rim
  if (amplitude.size() <= first) return 0;
  const auto peak = std::max_element(amplitude.begin() + first, amplitude.end());
  return *peak > kRoundRim * amplitude[0] ? static_cast<int>(peak - amplitude.begin()) : 0;
}

}  // namespace

std::vector<std::int32_t> rim_of(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  auto steps = boundary_steps(triangles);
  std::vector<std::int32_t> longest;
  double length = 0.0;
  while (!steps.empty()) {
    std::vector<std::int32_t> loop;
    for (auto step = steps.begin(); step != steps.end(); step = steps.find(loop.back())) {
      if (loop.empty()) loop.push_back(step->first);
      loop.push_back(step->second);
      steps.erase(step);
    }
    if (loop.front() == loop.back()) loop.pop_back();
    if (const double l = length_of(x, loop); l > length) {
      length = l;
      longest = std::move(loop);
    }
  }
  return longest;
}

RimProfile rim_profile(std::span<const Vec3> x, std::span<const Triangle> triangles,
                       const RimConfig& config) {
  constexpr int fewest = 8;
  require(config.samples >= fewest, "rim samples", config.samples, "at least 8");
  const std::vector<std::int32_t> rim = rim_of(x, triangles);
  if (rim.empty()) throw std::invalid_argument("measure: the surface is closed and has no rim");
  RimProfile profile;
  Vec3 centre = config.centre;
  centre.z() = 0.0;
  for (int k = 0; k < config.samples; ++k) {
    const RimPoint p = outermost(x, rim, centre, 2.0 * std::numbers::pi * k / config.samples);
    if (p.radius < 0.0)
      throw std::invalid_argument(
          "measure: the rim does not go around the centre; choose a centre inside the rim");
    profile.radius.push_back(p.radius);
    profile.height.push_back(p.height);
  }
  profile.amplitude = spectrum_of(profile.radius);
  profile.folds = strongest_order(profile.amplitude);
  const auto [low, high] = std::minmax_element(profile.radius.begin(), profile.radius.end());
  constexpr double stands_out = 0.1;
  if (profile.folds > 0) profile.maxima = count_maxima(profile.radius, stands_out * (*high - *low));
  return profile;
}

}  // namespace selvedge
