// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/detail/strip_path.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace selvedge::detail {

namespace {

// Chords instead of arcs shorten a turn of 90 degrees by (π/2/samples)²/24, relative: 2e-6.
constexpr int samples_per_segment = 256;

// Largest relative difference between the lengths of curve and grid; the start is stretched by it.
constexpr double length_tolerance = 0.01;

// Smallest sine of the angle between side and curve that gives a direction across.
constexpr double least_sine = 1e-3;

struct Sample {
  Vec3 point;
  double length = 0.0;  // along the curve up to here
  Vec3 tangent = Vec3::Zero(), across = Vec3::Zero();
};

// Barry and Goldman's pyramid for the segment p[1]-p[2], knots a half power of the chords apart.
Vec3 catmull_rom(const Vec3* p, double share) {
  double t[4] = {0.0};
  for (int i = 1; i < 4; ++i) t[i] = t[i - 1] + std::sqrt((p[i] - p[i - 1]).norm());
  const double at = t[1] + share * (t[2] - t[1]);
  const auto between = [&](const Vec3& a, const Vec3& b, double from, double to) {
    return Vec3(((to - at) * a + (at - from) * b) / (to - from));
  };
  const Vec3 a1 = between(p[0], p[1], t[0], t[1]), a2 = between(p[1], p[2], t[1], t[2]),
             a3 = between(p[2], p[3], t[2], t[3]);
  const Vec3 b1 = between(a1, a2, t[0], t[2]), b2 = between(a2, a3, t[1], t[3]);
  return between(b1, b2, t[1], t[2]);
}

std::vector<Sample> sample(std::vector<Vec3> points) {
  for (std::size_t i = 1; i < points.size(); ++i)
    if (points[i] == points[i - 1])
      throw std::invalid_argument(
          fmt::format("path: points {} and {} are the same; leave one of them out", i - 1, i));
  points.insert(points.begin(), 2.0 * points[0] - points[1]);
  points.push_back(2.0 * points.back() - points[points.size() - 2]);
  std::vector<Sample> samples;
  for (std::size_t i = 0; i + 3 < points.size(); ++i)
    for (int k = 0; k < samples_per_segment; ++k)
      samples.push_back({catmull_rom(&points[i], static_cast<double>(k) / samples_per_segment)});
  samples.push_back({points[points.size() - 2]});
  for (std::size_t i = 1; i < samples.size(); ++i)
    samples[i].length = samples[i - 1].length + (samples[i].point - samples[i - 1].point).norm();
  return samples;
}

void add_tangents(std::vector<Sample>& samples) {
  const std::size_t last = samples.size() - 1;
  for (std::size_t i = 0; i <= last; ++i)
    samples[i].tangent =
        (samples[std::min(i + 1, last)].point - samples[i > 0 ? i - 1 : 0].point).normalized();
}

// The part of the side that is perpendicular to the curve.
void add_across(std::vector<Sample>& samples, const Vec3& side) {
  for (Sample& s : samples) {
    const Vec3 across = side - side.dot(s.tangent) * s.tangent;
    if (!(across.norm() > least_sine * side.norm()))
      throw std::invalid_argument(fmt::format(
          "path: \"side\" runs along the curve at ({:g}, {:g}, {:g}); give a direction across it",
          s.point.x(), s.point.y(), s.point.z()));
    s.across = across.normalized();
  }
}

}  // namespace

std::vector<Vec3> lay_along(const StripPath& path, double size_x, const std::vector<Vec3>& flat) {
  std::vector<Sample> samples = sample(path.points);
  const double length = samples.back().length;
  if (std::abs(length - size_x) > length_tolerance * size_x)
    throw std::invalid_argument(
        fmt::format("path: the curve is {:.6g} m long and the cloth {:.6g} m; make \"size\" fit it",
                    length, size_x));
  add_tangents(samples);
  add_across(samples, path.side);
  std::vector<Vec3> placed;
  placed.reserve(flat.size());
  for (const Vec3& x : flat) {
    const double at = std::clamp(x.x() / size_x + 0.5, 0.0, 1.0) * length;
    auto next = std::lower_bound(samples.begin(), samples.end(), at,
                                 [](const Sample& s, double value) { return s.length < value; });
    next = std::clamp(next, samples.begin() + 1, samples.end() - 1);
    const Sample &a = *(next - 1), &b = *next;
    const double share = (at - a.length) / (b.length - a.length);
    placed.push_back((1.0 - share) * (a.point + x.y() * a.across) +
                     share * (b.point + x.y() * b.across));
  }
  return placed;
}

}  // namespace selvedge::detail
