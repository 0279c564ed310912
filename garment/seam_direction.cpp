// SPDX-License-Identifier: MIT
#include <selvedge/garment/detail/side_parity.h>
#include <selvedge/garment/sewing_pattern.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace selvedge {
namespace {

using Reason = SeamDirection::Reason;

/// Placement decides where the two sums of distances differ by more than this factor. Hoods and
/// cuffs stand far from the edge that they are sewn to, and the sums then hardly differ.
constexpr double kDecisive = 1.15;
/// A seam counts as twisted if the other way round were shorter by this factor.
constexpr double kTwisted = 1.3;
/// A panel shows one of its sides outward if it lies this far from the middle of the garment, m.
constexpr double kClearlyOut = 0.02;

/// Sums of the distances between the ends that meet, m.
struct EndDistances {
  double end_to_start, start_to_start;
  double ratio() const {
    const double most = std::max(end_to_start, start_to_start);
    const double least = std::min(end_to_start, start_to_start);
    return least > 1e-9 * most ? most / least : 1e9;
  }
};

EndDistances end_distances(const SewingPattern& pattern, const PatternStitch& stitch) {
  const auto end = [&](const PatternStitch::Side& side, int which) {
    const PatternPanel& panel = pattern.panels[side.panel];
    return place_point(panel, panel.vertices[panel.endpoints(side.edge)[which]]);
  };
  const Vec3 a0 = end(stitch.a, 0), a1 = end(stitch.a, 1), b0 = end(stitch.b, 0),
             b1 = end(stitch.b, 1);
  return {(a1 - b0).norm() + (a0 - b1).norm(), (a0 - b0).norm() + (a1 - b1).norm()};
}

/// In one panel, edges that follow each other share a vertex, at the end of one and the start of
/// the other.
bool share_an_end(const SewingPattern& pattern, const PatternStitch& stitch) {
  if (stitch.a.panel != stitch.b.panel) return false;
  const PatternPanel& panel = pattern.panels[stitch.a.panel];
  const auto &a = panel.endpoints(stitch.a.edge), &b = panel.endpoints(stitch.b.edge);
  return a[1] == b[0] || b[1] == a[0];
}

}  // namespace

std::vector<double> detail::outward_faces(const SewingPattern& pattern) {
  std::vector<Vec3> middle, normal;
  Vec3 sum = Vec3::Zero();
  double total = 0.0;
  for (const PatternPanel& panel : pattern.panels) {
    Vec2 mean = Vec2::Zero();
    for (const Vec2& v : panel.vertices) mean += v / static_cast<double>(panel.vertices.size());
    const double area = panel_area(panel);
    middle.push_back(place_point(panel, mean));
    normal.push_back((area < 0.0 ? -1.0 : 1.0) * panel.rotation.col(2));
    sum += std::abs(area) * middle.back();
    total += std::abs(area);
  }
  std::vector<double> faces;
  for (std::size_t p = 0; p < middle.size(); ++p)
    faces.push_back(normal[p].dot(middle[p] - sum / total));
  return faces;
}

std::vector<SeamDirection> seam_directions(const SewingPattern& pattern) {
  const std::size_t n = pattern.stitches.size();
  std::vector<SeamDirection> directions(n);
  std::vector<EndDistances> distances(n);
  std::vector<double> weight(n);
  for (std::size_t s = 0; s < n; ++s) {
    const PatternStitch& stitch = pattern.stitches[s];
    distances[s] = end_distances(pattern, stitch);
    weight[s] = distances[s].ratio();
    if (stitch.direction != PatternStitch::Direction::unknown) {
      directions[s].reason = Reason::file;
      directions[s].start_to_start = stitch.direction == PatternStitch::Direction::start_to_start;
      weight[s] = 1e12;
    } else if (share_an_end(pattern, stitch)) {
      directions[s].reason = Reason::shared_end;
      weight[s] = 1e12;
    } else if (weight[s] > kDecisive || pattern.is_on_a_line(stitch)) {
      directions[s].reason = Reason::placement;
      directions[s].start_to_start = distances[s].start_to_start < distances[s].end_to_start;
    }
  }
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t i, std::size_t j) { return weight[i] > weight[j]; });
  detail::SideParity sides(pattern.panels.size());
  const std::vector<double> faces = detail::outward_faces(pattern);
  for (const std::size_t s : order) {
    const PatternStitch& stitch = pattern.stitches[s];
    SeamDirection& direction = directions[s];
    const bool free = direction.reason == Reason::convention;
    if (free && sides.are_joined(stitch.a.panel, stitch.b.panel)) {
      direction.start_to_start = sides.are_opposite(stitch.a.panel, stitch.b.panel);
      direction.reason = Reason::orientation;
    } else if (const double a = faces[stitch.a.panel], b = faces[stitch.b.panel];
               free && std::min(std::abs(a), std::abs(b)) > kClearlyOut) {
      direction.start_to_start = (a < 0.0) != (b < 0.0);
      direction.reason = Reason::orientation;
    }
    // A panel may lie on either side of a line.
    if (!pattern.is_on_a_line(stitch))
      sides.join(stitch.a.panel, stitch.b.panel, direction.start_to_start);
    const bool other = distances[s].start_to_start < distances[s].end_to_start;
    direction.twisted = direction.start_to_start != other && distances[s].ratio() > kTwisted;
  }
  return directions;
}

}  // namespace selvedge
