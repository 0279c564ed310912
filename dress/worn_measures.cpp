// SPDX-License-Identifier: MIT
#include <selvedge/bodies/internal/triangle_tree.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/detail/deformation.h>
#include <selvedge/dress/detail/worn_measures.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

namespace selvedge::detail {
namespace {

constexpr double kFoldGap = 0.005;   // m, between layers of a fold
constexpr double kOpposite = -0.3;   // cosine of the normals of layers with opposite faces
constexpr double kAlong = 0.5;       // cosine between the way to the other layer and the body's
constexpr double kNearBody = 0.06;   // m, up to which cloth lies on the body
constexpr double kMirrored = 0.002;  // m, within which corners of a pattern are mirror images

Vec3 normal_of(const TriangleMesh& mesh, std::size_t i) {
  const Triangle& t = mesh.triangles[i];
  return (mesh.vertices[t[1]] - mesh.vertices[t[0]])
      .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]])
      .normalized();
}

Vec3 middle_of(const TriangleMesh& mesh, std::size_t i) {
  const Triangle& t = mesh.triangles[i];
  return (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3.0;
}

/// Normals of a body near points.
class BodyNormals {
 public:
  explicit BodyNormals(const TriangleMesh& body) : body_(body), tree_(body.triangles) {
    tree_.fit(body.vertices);
  }
  /// Of the triangle whose middle is nearest; nullopt far from the body.
  std::optional<Vec3> at(const Vec3& point) const {
    double least = kNearBody;
    std::int32_t nearest = -1;
    tree_.for_each_near(point, kNearBody, [&](std::int32_t k) {
      const double distance = (middle_of(body_, static_cast<std::size_t>(k)) - point).norm();
      if (distance > least || (distance == least && k > nearest)) return;
      least = distance;
      nearest = k;
    });
    if (nearest < 0) return std::nullopt;
    return normal_of(body_, static_cast<std::size_t>(nearest));
  }

 private:
  const TriangleMesh& body_;
  TriangleTree tree_;
};

/// A section of a mesh by a plane: one segment for each triangle that the plane cuts. Ends are
/// edges of the mesh.
struct Section {
  struct Segment {
    std::size_t triangle;
    std::array<Edge, 2> edge;
    std::array<double, 2> share;  // of the way from the first to the second vertex of the edge
  };
  std::vector<Segment> segments;
  std::vector<std::int32_t> part;  // per segment: those that hang together have the same
};

Section section_of(const TriangleMesh& mesh, const Vec3& point, const Vec3& normal) {
  Section section;
  std::map<Edge, std::vector<std::int32_t>> at;
  const auto height = [&](std::int32_t v) { return normal.dot(mesh.vertices[v] - point); };
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    Section::Segment segment{.triangle = i, .edge = {}, .share = {}};
    int ends = 0;
    for (int k = 0; k < 3 && ends < 2; ++k) {
      const std::int32_t u = mesh.triangles[i][k], v = mesh.triangles[i][(k + 1) % 3];
      const Edge edge = {std::min(u, v), std::max(u, v)};
      const double a = height(edge[0]), b = height(edge[1]);
      if ((a < 0.0) == (b < 0.0)) continue;
      segment.edge[ends] = edge;
      segment.share[ends++] = a / (a - b);
    }
    if (ends < 2) continue;
    for (const Edge& edge : segment.edge)
      at[edge].push_back(static_cast<std::int32_t>(section.segments.size()));
    section.segments.push_back(segment);
  }
  std::vector<std::int32_t>& part = section.part;
  part.resize(section.segments.size());
  std::iota(part.begin(), part.end(), 0);
  const auto root = [&](std::int32_t s) {
    while (part[s] != s) s = part[s] = part[part[s]];
    return s;
  };
  for (const auto& [edge, list] : at)
    for (const std::int32_t s : list) {
      const std::int32_t a = root(list.front()), b = root(s);
      part[std::max(a, b)] = std::min(a, b);
    }
  for (std::size_t s = 0; s < part.size(); ++s) part[s] = root(static_cast<std::int32_t>(s));
  return section;
}

Vec3 end_of(const TriangleMesh& mesh, const Edge& edge, double share) {
  return (1.0 - share) * mesh.vertices[edge[0]] + share * mesh.vertices[edge[1]];
}

using Point = Eigen::Vector2d;
double cross(const Point& a, const Point& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Corners of the convex hull, counter-clockwise.
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

double around(const std::vector<Point>& loop) {
  double length = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    length += (loop[(i + 1) % loop.size()] - loop[i]).norm();
  return length;
}

bool contains(const std::vector<Point>& hull, const Point& p) {
  for (std::size_t i = 0; i < hull.size(); ++i)
    if (cross(hull[(i + 1) % hull.size()] - hull[i], p - hull[i]) < 0.0) return false;
  return !hull.empty();
}

/// Length of a tape around the parts of the body inside a convex loop of the plane.
double tape(const TriangleMesh& body, const Vec3& point, const Vec3& normal,
            const std::array<Vec3, 2>& axes, const std::vector<Point>& loop) {
  const Section section = section_of(body, point, normal);
  std::map<std::int32_t, std::vector<Point>> parts;
  for (std::size_t s = 0; s < section.segments.size(); ++s)
    for (int k = 0; k < 2; ++k) {
      const Vec3 x =
          end_of(body, section.segments[s].edge[k], section.segments[s].share[k]) - point;
      parts[section.part[s]].push_back({axes[0].dot(x), axes[1].dot(x)});
    }
  std::vector<Point> inside;
  for (const auto& [part, points] : parts) {
    Point middle = Point::Zero();
    for (const Point& p : points) middle += p / static_cast<double>(points.size());
    if (contains(loop, middle)) inside.insert(inside.end(), points.begin(), points.end());
  }
  return inside.size() < 3 ? 0.0 : around(convex_hull(inside));
}

/// The most stretched place, with its measures.
void measure_tight(const TriangleMesh& body, DressResult& r) {
  double most = -1.0, all = 0.0, over = 0.0;
  std::size_t at = 0;
  for (std::size_t i = 0; i < r.garment.triangles.size(); ++i) {
    const Deformation d = deformation(r.garment, r.flat, i);
    const double strain = d.largest_strain();
    all += d.area;
    if (strain > r.wearable_stretch) over += d.area;
    if (strain <= most) continue;
    most = strain;
    at = i;
  }
  if (most < 0.0) return;
  const Vec3 along = deformation(r.garment, r.flat, at).direction();
  const Girth girth =
      girth_at(r.garment, r.flat, body, at, normal_of(r.garment, at).cross(along).normalized());
  r.tight = {.panel = r.panel_of_triangle[at],
             .at = middle_of(r.garment, at),
             .strain = most,
             .area_share = over / all,
             .cloth = girth.cloth,
             .body = girth.body};
}

/// Corners of the panels, as they stand in the pattern and as they are worn.
struct Corners {
  std::vector<Vec3> placed, worn;
  std::vector<std::int32_t> panel;
};

Corners corners_of(const Garment& start, const Garment& worn) {
  Corners corners;
  for (std::size_t b = 0; b < start.borders.size(); ++b) {
    const std::int32_t from = start.borders[b].vertices.front(),
                       now = worn.borders[b].vertices.front();
    corners.placed.push_back(start.surface.vertices[start.corner[from]]);
    corners.worn.push_back(worn.surface.vertices[worn.corner[now]]);
    corners.panel.push_back(start.borders[b].panel);
  }
  return corners;
}

/// The mean over the corners of a panel of how far each is from the mirror image of its partner;
/// the largest of all panels. -1 for a pattern that is not its own mirror image.
void measure_asymmetry(const Garment& start, const Garment& worn, DressResult& r) {
  const Corners corners = corners_of(start, worn);
  if (corners.placed.empty()) return;
  double low = corners.placed[0].x(), high = low;
  for (const Vec3& x : corners.placed) {
    low = std::min(low, x.x());
    high = std::max(high, x.x());
  }
  const auto mirrored = [&](Vec3 x) {
    x.x() = low + high - x.x();
    return x;
  };
  std::vector<double> sum(r.panel_names.size(), 0.0), count(r.panel_names.size(), 0.0);
  for (std::size_t i = 0; i < corners.placed.size(); ++i) {
    std::size_t partner = corners.placed.size();
    double least = kMirrored;
    for (std::size_t k = 0; k < corners.placed.size(); ++k) {
      const double distance = (mirrored(corners.placed[i]) - corners.placed[k]).norm();
      // Of corners at one place, that of the same panel: a front has its own mirror image.
      if (distance > least || (distance == least && partner < corners.placed.size() &&
                               corners.panel[k] != corners.panel[i]))
        continue;
      least = distance;
      partner = k;
    }
    if (partner == corners.placed.size()) return;
    const auto p = static_cast<std::size_t>(corners.panel[i]);
    sum[p] += (mirrored(corners.worn[i]) - corners.worn[partner]).norm();
    count[p] += 1.0;
  }
  r.asymmetry = 0.0;
  for (std::size_t p = 0; p < sum.size(); ++p) {
    if (count[p] == 0.0 || sum[p] / count[p] <= r.asymmetry) continue;
    r.asymmetry = sum[p] / count[p];
    r.asymmetric_panel = static_cast<std::int32_t>(p);
  }
}

}  // namespace

std::vector<double> folded_areas(const TriangleMesh& garment,
                                 std::span<const std::int32_t> panel_of_triangle,
                                 const TriangleMesh& body, std::size_t panels) {
  const std::vector<Vec3> normals = vertex_normals(garment.vertices, garment.triangles);
  std::vector<std::vector<std::int32_t>> panels_at(garment.vertices.size());
  for (std::size_t i = 0; i < garment.triangles.size(); ++i)
    for (const std::int32_t v : garment.triangles[i]) panels_at[v].push_back(panel_of_triangle[i]);
  const BodyNormals outward(body);
  std::vector<char> is_folded(garment.vertices.size(), 0);
  for (const Proximity& near : find_contacts(garment.vertices, garment.triangles, kFoldGap)) {
    if (near.kind == ContactKind::edge_edge) continue;
    const std::int32_t v = near.vertex[0];
    const auto t = static_cast<std::size_t>(near.primitive_b);
    const std::vector<std::int32_t>& own = panels_at[v];
    if (std::find(own.begin(), own.end(), panel_of_triangle[t]) == own.end()) continue;
    if (normals[v].dot(normal_of(garment, t)) > kOpposite) continue;
    const auto out = outward.at(garment.vertices[v]);
    if (!out || std::abs(near.normal.dot(*out)) < kAlong) continue;
    is_folded[v] = 1;  // the vertices of the other layer have pairs of their own
  }
  std::vector<double> folded(panels, 0.0), area(panels, 0.0);
  for (std::size_t i = 0; i < garment.triangles.size(); ++i) {
    const Triangle& t = garment.triangles[i];
    const double third = 0.5 / 3.0 *
                         (garment.vertices[t[1]] - garment.vertices[t[0]])
                             .cross(garment.vertices[t[2]] - garment.vertices[t[0]])
                             .norm();
    const auto p = static_cast<std::size_t>(panel_of_triangle[i]);
    area[p] += 3.0 * third;
    for (const std::int32_t v : t)
      if (is_folded[v]) folded[p] += third;
  }
  for (std::size_t p = 0; p < panels; ++p) folded[p] = area[p] > 0.0 ? folded[p] / area[p] : 0.0;
  return folded;
}

Girth girth_at(const TriangleMesh& garment, const TriangleMesh& flat, const TriangleMesh& body,
               std::size_t triangle, const Vec3& normal) {
  const Vec3 point = middle_of(garment, triangle);
  const Section section = section_of(garment, point, normal);
  std::int32_t part = -1;
  for (std::size_t s = 0; s < section.segments.size(); ++s)
    if (section.segments[s].triangle == triangle) part = section.part[s];
  if (part < 0) return {};
  const Vec3 first = normal.unitOrthogonal();
  const std::array<Vec3, 2> axes = {first, normal.cross(first)};
  Girth girth;
  std::vector<Point> loop;
  std::map<Edge, int> uses;
  for (std::size_t s = 0; s < section.segments.size(); ++s) {
    if (section.part[s] != part) continue;
    const auto& [t, edge, share] = section.segments[s];
    std::array<Vec3, 2> now, rest;
    for (int k = 0; k < 2; ++k) {
      ++uses[edge[k]];
      now[k] = end_of(garment, edge[k], share[k]);
      loop.push_back({axes[0].dot(now[k] - point), axes[1].dot(now[k] - point)});
      rest[k] = Vec3::Zero();
      for (int c = 0; c < 3; ++c)
        for (int e = 0; e < 2; ++e)
          if (garment.triangles[t][c] == edge[k][e])
            rest[k] += (e == 0 ? 1.0 - share[k] : share[k]) * flat.vertices[flat.triangles[t][c]];
    }
    girth.worn += (now[1] - now[0]).norm();
    girth.cloth += (rest[1] - rest[0]).norm();
  }
  for (const auto& [edge, count] : uses)
    if (count != 2) return {};  // open, or more than a loop
  girth.body = tape(body, point, normal, axes, convex_hull(std::move(loop)));
  return girth;
}

void measure_worn(const Garment& start, const Garment& worn, DressResult& r) {
  r.panel_folded = folded_areas(r.garment, r.panel_of_triangle, r.body, r.panel_names.size());
  std::vector<double> area(r.panel_names.size(), 0.0);
  for (std::size_t i = 0; i < r.flat.triangles.size(); ++i)
    area[static_cast<std::size_t>(r.panel_of_triangle[i])] +=
        deformation(r.garment, r.flat, i).area;
  const double all = std::accumulate(area.begin(), area.end(), 0.0);
  for (std::size_t p = 0; p < area.size(); ++p) r.folded += r.panel_folded[p] * area[p] / all;
  measure_tight(r.body, r);
  measure_asymmetry(start, worn, r);
}

}  // namespace selvedge::detail
