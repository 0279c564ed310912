// SPDX-License-Identifier: MIT
#include <selvedge/dress/detail/girth.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace selvedge::detail {
namespace {

using Point = Eigen::Vector2d;

double cross(const Point& a, const Point& b) { return a.x() * b.y() - a.y() * b.x(); }

/// The segments of all parts, in the order of their triangles.
std::vector<Section::Segment> cut(const TriangleMesh& mesh, const CutPlane& plane) {
  std::vector<double> height;
  height.reserve(mesh.vertices.size());
  for (const Vec3& x : mesh.vertices) height.push_back(plane.height(x));
  std::vector<Section::Segment> segments;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    if ((height[t[0]] < 0.0) == (height[t[1]] < 0.0) &&
        (height[t[0]] < 0.0) == (height[t[2]] < 0.0))
      continue;
    Section::Segment segment{.triangle = i, .edge = {}, .share = {}};
    int ends = 0;
    for (int k = 0; k < 3 && ends < 2; ++k) {
      const std::int32_t u = t[k], v = t[(k + 1) % 3];
      const Edge edge = {std::min(u, v), std::max(u, v)};
      const double a = height[edge[0]], b = height[edge[1]];
      if ((a < 0.0) == (b < 0.0)) continue;
      segment.edge[ends] = edge;
      segment.share[ends++] = a / (a - b);
    }
    if (ends == 2) segments.push_back(segment);
  }
  return segments;
}

/// For each segment the first one with which it hangs together.
std::vector<std::int32_t> roots_of(const std::vector<Section::Segment>& segments) {
  std::map<Edge, std::int32_t> first;
  std::vector<std::int32_t> part(segments.size());
  std::iota(part.begin(), part.end(), 0);
  const auto root = [&](std::int32_t s) {
    while (part[s] != s) s = part[s] = part[part[s]];
    return s;
  };
  for (std::size_t s = 0; s < segments.size(); ++s)
    for (const Edge& edge : segments[s].edge) {
      const auto found = first.try_emplace(edge, static_cast<std::int32_t>(s)).first;
      const std::int32_t a = root(found->second), b = root(static_cast<std::int32_t>(s));
      part[std::max(a, b)] = std::min(a, b);
    }
  for (std::size_t s = 0; s < part.size(); ++s) part[s] = root(static_cast<std::int32_t>(s));
  return part;
}

void measure(const TriangleMesh& mesh, const CutPlane& plane, Section::Part& part) {
  std::vector<Point> points;
  std::map<Edge, int> uses;
  for (const Section::Segment& segment : part.segments) {
    for (int k = 0; k < 2; ++k) {
      points.push_back(plane.flat(end_of(mesh, segment, k)));
      ++uses[segment.edge[k]];
    }
    const Point &a = points[points.size() - 2], &b = points.back();
    const double length = (b - a).norm();
    part.middle += 0.5 * length * (a + b);
    part.length += length;
  }
  if (part.length > 0.0) part.middle /= part.length;
  part.is_ring =
      std::all_of(uses.begin(), uses.end(), [](const auto& use) { return use.second == 2; });
  part.hull = convex_hull(std::move(points));
  part.tape = around(part.hull);
}

}  // namespace

CutPlane::CutPlane(const Vec3& point, const Vec3& normal)
    : point_(point), normal_(normal.normalized()) {
  axes_[0] = normal_.unitOrthogonal();
  axes_[1] = normal_.cross(axes_[0]);
}

Eigen::Vector2d CutPlane::flat(const Vec3& x) const {
  return {axes_[0].dot(x - point_), axes_[1].dot(x - point_)};
}

Vec3 CutPlane::in_space(const Point& p) const {
  return point_ + p.x() * axes_[0] + p.y() * axes_[1];
}

Section section_of(const TriangleMesh& mesh, const CutPlane& plane) {
  Section section;
  const std::vector<Section::Segment> segments = cut(mesh, plane);
  const std::vector<std::int32_t> root = roots_of(segments);
  std::vector<std::int32_t> number(segments.size(), -1);  // of the part, by its root
  for (std::size_t s = 0; s < segments.size(); ++s) {
    std::int32_t& part = number[root[s]];
    if (part < 0) {
      part = static_cast<std::int32_t>(section.parts.size());
      section.parts.emplace_back();
    }
    section.parts[part].segments.push_back(segments[s]);
  }
  for (Section::Part& part : section.parts) measure(mesh, plane, part);
  return section;
}

Vec3 end_of(const TriangleMesh& mesh, const Section::Segment& segment, int end) {
  const auto& [u, v] = segment.edge[end];
  return (1.0 - segment.share[end]) * mesh.vertices[u] + segment.share[end] * mesh.vertices[v];
}

double length_in(const TriangleMesh& other, const TriangleMesh& mesh,
                 std::span<const Section::Segment> segments) {
  double length = 0.0;
  for (const Section::Segment& segment : segments) {
    const Triangle &t = mesh.triangles[segment.triangle], &f = other.triangles[segment.triangle];
    std::array<Vec3, 2> x = {Vec3::Zero(), Vec3::Zero()};
    for (int k = 0; k < 2; ++k)
      for (int c = 0; c < 3; ++c)
        for (int e = 0; e < 2; ++e)
          if (t[c] == segment.edge[k][e])
            x[k] += (e == 0 ? 1.0 - segment.share[k] : segment.share[k]) * other.vertices[f[c]];
    length += (x[1] - x[0]).norm();
  }
  return length;
}

std::vector<Point> convex_hull(std::vector<Point> points) {
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) {
    return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y());
  });
  if (points.size() < 3) return points;
  std::vector<Point> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t first = hull.size();
    for (const Point& p : points) {
      while (hull.size() >= first + 2 &&
             cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0.0)
        hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

bool contains(std::span<const Point> hull, const Point& p) {
  for (std::size_t i = 0; i < hull.size(); ++i)
    if (cross(hull[(i + 1) % hull.size()] - hull[i], p - hull[i]) < 0.0) return false;
  return !hull.empty();
}

double around(std::span<const Point> loop) {
  double length = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    length += (loop[(i + 1) % loop.size()] - loop[i]).norm();
  return length;
}

double tape_inside(const Section& section, std::span<const Point> loop) {
  std::vector<Point> corners;
  for (const Section::Part& part : section.parts)
    if (contains(loop, part.middle))
      corners.insert(corners.end(), part.hull.begin(), part.hull.end());
  return corners.size() < 3 ? 0.0 : around(convex_hull(std::move(corners)));
}

}  // namespace selvedge::detail
