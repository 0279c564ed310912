// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/garment/sewing_pattern.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace selvedge {
namespace {

using Kind = PatternCurve::Kind;

/// Chords of a Bezier curve for its length: the error is below 1e-6 of the length.
constexpr std::int32_t kChords = 1024;

struct Arc {
  Vec2 center;
  double radius, first, sweep;  // rad, the sweep is negative if clockwise
};

Vec2 left_of(const Vec2& v) { return {-v.y(), v.x()}; }

/// As in SVG 1.1, appendix F.6.5, for a circle. A radius that is too small counts as half the
/// distance of the ends.
Arc arc_of(const Vec2& start, const Vec2& end, const PatternCurve& curve) {
  const Vec2 chord = end - start;
  const double half = 0.5 * chord.norm(), radius = std::max(curve.radius, half);
  const double height = std::sqrt(std::max(0.0, radius * radius - half * half));
  const double side = curve.clockwise == curve.large_arc ? 1.0 : -1.0;
  Arc arc;
  arc.center = 0.5 * (start + end) + side * height / (2.0 * half) * left_of(chord);
  arc.radius = radius;
  const Vec2 from = start - arc.center;
  arc.first = elementary::atan2(from.y(), from.x());
  const double small = 2.0 * elementary::asin(std::min(1.0, half / radius));
  const double angle = curve.large_arc ? 2.0 * std::numbers::pi - small : small;
  arc.sweep = curve.clockwise ? -angle : angle;
  return arc;
}

Vec2 bezier_point(const Vec2& start, const Vec2& end, const PatternCurve& curve, double t) {
  const double s = 1.0 - t;
  if (curve.kind == Kind::quadratic)
    return s * s * start + 2.0 * s * t * curve.control[0] + t * t * end;
  return s * s * s * start + 3.0 * s * s * t * curve.control[0] +
         3.0 * s * t * t * curve.control[1] + t * t * t * end;
}

/// All points of a polyline.
std::vector<Vec2> points_of(const Vec2& start, const Vec2& end, const PatternCurve& curve) {
  std::vector<Vec2> points = {start};
  points.insert(points.end(), curve.through.begin(), curve.through.end());
  points.push_back(end);
  return points;
}

double length_of(std::span<const Vec2> points) {
  double length = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).norm();
  return length;
}

/// The index of the point before the place at this length from the start, and the place.
std::pair<std::size_t, Vec2> place_on(std::span<const Vec2> points, double wanted) {
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const double step = (points[i] - points[i - 1]).norm();
    if (wanted < step) return {i - 1, points[i - 1] + wanted / step * (points[i] - points[i - 1])};
    wanted -= step;
  }
  const Vec2 &last = points[points.size() - 1], &before = points[points.size() - 2];
  const double step = (last - before).norm();
  const double share = step > 0.0 ? std::clamp(wanted / step, 0.0, 1.0) : 1.0;
  return {points.size() - 2, before + share * (last - before)};
}

const Vec2& start_of(const PatternPanel& panel, std::int32_t edge) {
  return panel.vertices[panel.endpoints(edge)[0]];
}
const Vec2& end_of(const PatternPanel& panel, std::int32_t edge) {
  return panel.vertices[panel.endpoints(edge)[1]];
}
const PatternCurve& curve_of(const PatternPanel& panel, std::int32_t edge) {
  static const PatternCurve straight;
  return panel.is_line(edge) ? straight : panel.edges[edge].curve;
}

bool is_bezier(const PatternCurve& curve) {
  return curve.kind == Kind::quadratic || curve.kind == Kind::cubic;
}

/// Lengths from the start to each end of a chord, m.
std::vector<double> chord_lengths(const PatternPanel& panel, std::int32_t edge) {
  std::vector<double> length(kChords + 1, 0.0);
  Vec2 last = start_of(panel, edge);
  for (std::int32_t i = 1; i <= kChords; ++i) {
    const Vec2 next = edge_point(panel, edge, static_cast<double>(i) / kChords);
    length[i] = length[i - 1] + (next - last).norm();
    last = next;
  }
  return length;
}

/// Parameter at which a Bezier curve has this length from its start.
double parameter_at(const std::vector<double>& length, double wanted) {
  const auto above = std::upper_bound(length.begin() + 1, length.end() - 1, wanted);
  const std::int64_t i = above - length.begin();
  const double step = length[i] - length[i - 1];
  const double part = step > 0.0 ? (wanted - length[i - 1]) / step : 0.0;
  return (static_cast<double>(i - 1) + std::clamp(part, 0.0, 1.0)) / kChords;
}

}  // namespace

Vec2 edge_point(const PatternPanel& panel, std::int32_t edge, double t) {
  const Vec2 &start = start_of(panel, edge), &end = end_of(panel, edge);
  const PatternCurve& curve = curve_of(panel, edge);
  if (t <= 0.0) return start;
  if (t >= 1.0) return end;
  if (curve.kind == Kind::straight) return start + t * (end - start);
  if (is_bezier(curve)) return bezier_point(start, end, curve, t);
  if (curve.kind == Kind::polyline) {
    const std::vector<Vec2> points = points_of(start, end, curve);
    return place_on(points, t * length_of(points)).second;
  }
  const Arc arc = arc_of(start, end, curve);
  const double angle = arc.first + t * arc.sweep;
  return arc.center + arc.radius * Vec2(elementary::cos(angle), elementary::sin(angle));
}

double edge_length(const PatternPanel& panel, std::int32_t edge) {
  const PatternCurve& curve = curve_of(panel, edge);
  if (is_bezier(curve)) return chord_lengths(panel, edge).back();
  if (curve.kind == Kind::straight) return (end_of(panel, edge) - start_of(panel, edge)).norm();
  if (curve.kind == Kind::polyline)
    return length_of(points_of(start_of(panel, edge), end_of(panel, edge), curve));
  const Arc arc = arc_of(start_of(panel, edge), end_of(panel, edge), curve);
  return arc.radius * std::abs(arc.sweep);
}

double edge_turning(const PatternPanel& panel, std::int32_t edge) {
  const PatternCurve& curve = curve_of(panel, edge);
  if (curve.kind == Kind::straight) return 0.0;
  if (curve.kind == Kind::arc)
    return std::abs(arc_of(start_of(panel, edge), end_of(panel, edge), curve).sweep);
  constexpr std::int32_t samples = 64;
  double turning = 0.0;
  Vec2 last = start_of(panel, edge), direction = Vec2::Zero();
  for (std::int32_t i = 1; i <= samples; ++i) {
    const Vec2 next = edge_point(panel, edge, static_cast<double>(i) / samples);
    const Vec2 step = next - last;
    if (step.squaredNorm() == 0.0) continue;
    if (direction.squaredNorm() > 0.0)
      turning += std::abs(elementary::atan2(left_of(direction).dot(step), direction.dot(step)));
    direction = step;
    last = next;
  }
  return turning;
}

std::vector<Vec2> divide_edge(const PatternPanel& panel, std::int32_t edge, std::int32_t pieces) {
  const bool bezier = is_bezier(curve_of(panel, edge));
  const std::vector<double> length = bezier ? chord_lengths(panel, edge) : std::vector<double>{};
  std::vector<Vec2> points;
  points.reserve(pieces + 1);
  for (std::int32_t i = 0; i <= pieces; ++i) {
    const double share = static_cast<double>(i) / pieces;
    const bool within = i > 0 && i < pieces;
    points.push_back(edge_point(
        panel, edge, bezier && within ? parameter_at(length, share * length.back()) : share));
  }
  return points;
}

EdgeParts split_edge(const PatternPanel& panel, std::int32_t edge, std::span<const double> shares) {
  const PatternCurve& curve = panel.edges[edge].curve;
  const Vec2 start = start_of(panel, edge), end = end_of(panel, edge);
  EdgeParts parts;
  std::vector<double> at = {0.0};  // parameters
  const std::vector<double> chords =
      is_bezier(curve) ? chord_lengths(panel, edge) : std::vector<double>{};
  for (const double share : shares)
    at.push_back(is_bezier(curve) ? parameter_at(chords, share * chords.back()) : share);
  at.push_back(1.0);
  for (std::size_t i = 1; i + 1 < at.size(); ++i)
    parts.points.push_back(edge_point(panel, edge, at[i]));
  const std::vector<Vec2> line = points_of(start, end, curve);
  const double length = length_of(line);
  for (std::size_t i = 1; i < at.size(); ++i) {
    PatternCurve& part = parts.curves.emplace_back(curve);
    if (is_bezier(curve)) {
      // Derivatives at both ends fix the control points of the part.
      const double h = at[i] - at[i - 1];
      const auto blend = [&](double t, double u, const Vec2& p, const Vec2& q, const Vec2& r) {
        return Vec2((1 - t) * ((1 - u) * p + u * q) + t * ((1 - u) * q + u * r));
      };
      const double t = at[i - 1], u = t + h;
      const Vec2 &c = curve.control[0], &d = curve.control[1];
      if (curve.kind == Kind::quadratic) {
        part.control[0] = blend(t, u, start, c, end);
      } else {
        const auto blossom = [&](double r, double s, double w) {
          return Vec2((1 - w) * blend(r, s, start, c, d) + w * blend(r, s, c, d, end));
        };
        part.control = {blossom(t, t, u), blossom(t, u, u)};
      }
    } else if (curve.kind == Kind::arc) {
      part.radius = arc_of(start, end, curve).radius;
      part.large_arc =
          std::abs(arc_of(start, end, curve).sweep) * (at[i] - at[i - 1]) > std::numbers::pi;
    } else if (curve.kind == Kind::polyline) {
      const std::size_t first = place_on(line, at[i - 1] * length).first,
                        last = place_on(line, at[i] * length).first;
      part.through.assign(line.begin() + static_cast<std::ptrdiff_t>(first) + 1,
                          line.begin() + static_cast<std::ptrdiff_t>(last) + 1);
      // A point of the line at the end of the part is the end itself.
      const Vec2 from = i == 1 ? start : parts.points[i - 2],
                 to = i + 1 == at.size() ? end : parts.points[i - 1];
      const auto is_end = [&](const Vec2& p) {
        return (p - from).norm() < 1e-9 * length || (p - to).norm() < 1e-9 * length;
      };
      std::erase_if(part.through, is_end);
      if (part.through.empty()) part.kind = Kind::straight;
    }
  }
  return parts;
}

Vec3 place_point(const PatternPanel& panel, const Vec2& point) {
  if (panel.bend.radius == 0.0)
    return panel.rotation * Vec3(point.x(), point.y(), 0.0) + panel.translation;
  const PatternBend& bend = panel.bend;
  const Vec2 from = point - bend.at, across = left_of(bend.axis);
  const auto [sine, cosine] = elementary::sin_cos(from.dot(across) / bend.radius);
  const Vec2 flat = bend.at + from.dot(bend.axis) * bend.axis + bend.radius * sine * across;
  return panel.rotation * Vec3(flat.x(), flat.y(), -bend.radius * (1.0 - cosine)) +
         panel.translation;
}

double panel_area(const PatternPanel& panel) {
  const Vec2 origin = panel.vertices.empty() ? Vec2(Vec2::Zero()) : panel.vertices[0];
  double twice = 0.0;
  for (std::int32_t e = 0; e < static_cast<std::int32_t>(panel.edges.size()); ++e) {
    const PatternCurve& curve = panel.edges[e].curve;
    const bool is_line = curve.kind == Kind::straight || curve.kind == Kind::polyline;
    std::vector<Vec2> points;
    if (is_line) points = points_of(start_of(panel, e), end_of(panel, e), curve);
    for (std::int32_t i = 0; !is_line && i <= 256; ++i)
      points.push_back(edge_point(panel, e, i / 256.0));
    for (std::size_t i = 1; i < points.size(); ++i)
      twice += left_of(points[i - 1] - origin).dot(points[i] - origin);
  }
  return 0.5 * twice;
}

}  // namespace selvedge
