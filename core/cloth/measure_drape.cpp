// SPDX-License-Identifier: MIT
//
// G. E. Cusick, "The measurement of fabric drape", Journal of the Textile Institute 59 (1968): the
// fraction of the overhanging ring of a disc that its shadow covers. Along a line y = const the
// width of the shadow is linear in y between the corners of its outline. These corners are ends and
// crossings of contour edges, that is, edges of one triangle or between triangles that face up and
// down. The midpoint rule over the slabs between these heights is therefore exact.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/measure.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>

namespace selvedge {
namespace {

double cross(const Vec3& a, const Vec3& b) { return a.x() * b.y() - a.y() * b.x(); }

double signed_area(std::span<const Vec3> x, const Triangle& t) {
  return 0.5 * cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]]);
}

void require_mesh(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  validate(TriangleMesh{{x.begin(), x.end()}, {triangles.begin(), triangles.end()}}, "measure");
}

/// Facing of the triangles at an edge, as far as the outline needs it.
struct EdgeFaces {
  int triangles = 0;
  bool up = false, down = false;
};

std::map<Edge, EdgeFaces> faces_of_edges(std::span<const Vec3> x,
                                         std::span<const Triangle> triangles) {
  std::map<Edge, EdgeFaces> faces;
  for (const Triangle& t : triangles) {
    const double area = signed_area(x, t);
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = t[k], b = t[(k + 1) % 3];
      EdgeFaces& f = faces[{std::min(a, b), std::max(a, b)}];
      ++f.triangles;
      // A triangle seen edge-on faces both ways, so its edges count as contours. That only costs
      // time.
      f.up = f.up || area >= 0.0;
      f.down = f.down || area <= 0.0;
    }
  }
  return faces;
}

/// An edge from lower to higher y.
struct Segment {
  Vec3 low, high;
};

std::vector<Segment> contour_edges(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  std::vector<Segment> contours;
  for (const auto& [edge, f] : faces_of_edges(x, triangles)) {
    if (f.triangles == 2 && !(f.up && f.down)) continue;
    const Vec3 &a = x[edge[0]], &b = x[edge[1]];
    if (a.y() == b.y()) continue;
    contours.push_back(a.y() < b.y() ? Segment{a, b} : Segment{b, a});
  }
  return contours;
}

/// Adds the height at which two segments cross to `heights`, if they cross.
void add_crossing(const Segment& a, const Segment& b, std::vector<double>& heights) {
  const Vec3 u = a.high - a.low, v = b.high - b.low, w = b.low - a.low;
  const double parallel = cross(u, v);
  if (parallel == 0.0) return;
  const double s = cross(w, v) / parallel, t = cross(w, u) / parallel;
  if (s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0) heights.push_back(a.low.y() + s * u.y());
}

/// For a total order: the height at which two segments cross is rounded, so it depends on which of
/// them comes first.
std::array<double, 6> height_first(const Segment& s) {
  return {s.low.y(), s.low.x(), s.high.y(), s.high.x(), s.low.z(), s.high.z()};
}

std::vector<double> event_heights(std::vector<Segment> contours) {
  std::vector<double> heights;
  std::sort(contours.begin(), contours.end(),
            [](const Segment& a, const Segment& b) { return height_first(a) < height_first(b); });
  for (std::size_t i = 0; i < contours.size(); ++i) {
    heights.push_back(contours[i].low.y());
    heights.push_back(contours[i].high.y());
    for (std::size_t j = i + 1; j < contours.size() && contours[j].low.y() < contours[i].high.y();
         ++j)
      add_crossing(contours[i], contours[j], heights);
  }
  std::sort(heights.begin(), heights.end());
  heights.erase(std::unique(heights.begin(), heights.end()), heights.end());
  return heights;
}

/// The interval of the line at height y that a triangle covers.
struct Interval {
  double begin, end;
};

Interval interval_at(std::span<const Vec3> x, const Triangle& t, double y) {
  Interval interval{std::numeric_limits<double>::infinity(),
                    -std::numeric_limits<double>::infinity()};
  for (int k = 0; k < 3; ++k) {
    const Vec3 &a = x[t[k]], &b = x[t[(k + 1) % 3]];
    if ((a.y() < y) == (b.y() < y)) continue;
    const double at = a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    interval.begin = std::min(interval.begin, at);
    interval.end = std::max(interval.end, at);
  }
  return interval;
}

double union_length(std::vector<Interval>& intervals) {
  std::sort(intervals.begin(), intervals.end(), [](const Interval& a, const Interval& b) {
    return a.begin != b.begin ? a.begin < b.begin : a.end < b.end;
  });
  double length = 0.0, reach = -std::numeric_limits<double>::infinity();
  for (const Interval& i : intervals) {
    if (i.end > reach) length += i.end - std::max(i.begin, reach);
    reach = std::max(reach, i.end);
  }
  return length;
}

/// A triangle and its range of heights.
struct Span {
  double low, high;
  Triangle t;
};

std::vector<Span> spans_by_height(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  std::vector<Span> spans;
  spans.reserve(triangles.size());
  for (const Triangle& t : triangles) {
    const auto [low, high] = std::minmax({x[t[0]].y(), x[t[1]].y(), x[t[2]].y()});
    spans.push_back({low, high, t});
  }
  std::sort(spans.begin(), spans.end(), [](const Span& a, const Span& b) {
    return a.low != b.low ? a.low < b.low : a.t < b.t;
  });
  return spans;
}

}  // namespace

double surface_area(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  double area = 0.0;
  for (const Triangle& t : triangles)
    area += 0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).norm();
  return area;
}

double projected_area(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  require_mesh(x, triangles);
  const std::vector<double> heights = event_heights(contour_edges(x, triangles));
  const std::vector<Span> spans = spans_by_height(x, triangles);
  std::vector<Span> active;
  std::vector<Interval> intervals;
  std::size_t next = 0;
  double area = 0.0;
  for (std::size_t k = 0; k + 1 < heights.size(); ++k) {
    const double y = 0.5 * (heights[k] + heights[k + 1]);
    while (next < spans.size() && spans[next].low < y) active.push_back(spans[next++]);
    std::erase_if(active, [&](const Span& s) { return s.high <= y; });
    intervals.clear();
    for (const Span& s : active) intervals.push_back(interval_at(x, s.t, y));
    area += union_length(intervals) * (heights[k + 1] - heights[k]);
  }
  return area;
}

double drape_coefficient(double shadow, double specimen, double support) {
  require(std::isfinite(support) && support > 0.0, "support area in m2", support, "positive");
  require(std::isfinite(specimen) && specimen > support, "specimen area in m2", specimen,
          "larger than the support's");
  require(std::isfinite(shadow) && shadow >= 0.0, "shadow area in m2", shadow, "at least 0");
  return 100.0 * (shadow - support) / (specimen - support);
}

namespace {

/// Horizontal reach of a strip of length `length` that is clamped horizontally and bends under its
/// own weight: B θ'' = w s cos θ with θ'(free end) = 0. Shooting from the free end solves θ(clamp)
/// = 0. `c` = (B/w)^⅓.
double cantilever_reach(double c, double length) {
  constexpr int steps = 400;
  constexpr int halvings = 60;
  const double h = length / steps, k = 1.0 / (c * c * c);
  double reach = 0.0;
  // θ is the angle below the horizontal, s the distance from the free end; θ decreases towards the
  // clamp.
  const auto clamp_angle = [&](double tip) {
    double angle = tip, rate = 0.0;
    reach = 0.0;
    const auto slope = [&](double s, double a) { return -k * s * elementary::cos(a); };
    for (int i = 0; i < steps; ++i) {  // velocity Verlet
      const double s = i * h, before = slope(s, angle);
      const double next = angle + h * rate + 0.5 * h * h * before;
      rate += 0.5 * h * (before + slope(s + h, next));
      reach += h * 0.5 * (elementary::cos(angle) + elementary::cos(next));
      angle = next;
    }
    return angle;
  };
  // Deviation of the tip from the vertical. Soft strips deviate little. For a larger deviation the
  // solution would wind past the clamp angle and reach it again, so the first sign change, starting
  // at the vertical, is the solution.
  constexpr double least = 1e-14, factor = 1.5;
  constexpr double vertical = 0.5 * std::numbers::pi;
  double low = least, high = least;
  while (high < vertical && clamp_angle(vertical - high) > 0.0) {
    low = high;
    high *= factor;
  }
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (low + high);
    (clamp_angle(vertical - middle) > 0.0 ? low : high) = middle;
  }
  clamp_angle(vertical - low);
  return reach;
}

}  // namespace

double strip_drape_coefficient(double bending_length) {
  require(std::isfinite(bending_length) && bending_length > 0.0, "bending length in m",
          bending_length, "positive");
  constexpr double support = 0.09, overhang = 0.06;  // m, 18 cm disc, 30 cm specimen
  constexpr double specimen = support + overhang;
  const double rim = support + cantilever_reach(bending_length, overhang);
  return drape_coefficient(rim * rim, specimen * specimen, support * support);
}

}  // namespace selvedge
