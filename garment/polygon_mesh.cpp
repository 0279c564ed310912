// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/garment/detail/panel_quality.h>
#include <selvedge/garment/detail/size_field.h>
#include <selvedge/garment/detail/triangulation.h>
#include <selvedge/garment/panel_mesh.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <queue>
#include <stdexcept>

namespace selvedge {
namespace {

using detail::GridPlane;
using detail::GridPoint;
using detail::SizeField;
using detail::Triangulation;

// All distances are in units of the local size.
constexpr double kLatticeClearance = 0.62;  // of a point of the lattice from the border
constexpr double kInsertClearance = 0.45;   // of any other inner point from the border
constexpr double kInsertSpacing = 0.25;     // of a centroid from the points around it
constexpr double kCoarse = 0.8;  // radius of the circumcircle above which a point is inserted; that
                                 // of an equilateral triangle is 0.577
/// Below this angle a sweep must not make a triangle worse, rad.
constexpr double kGoodAngle = 40.0 * std::numbers::pi / 180.0;

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

class PolygonMesher {
 public:
  PolygonMesher(const PanelOutline& outline, const PanelMeshConfig& config, const GridPlane& plane,
                const std::vector<GridPoint>& points)
      : config_(config),
        plane_(plane),
        sides_(static_cast<std::int32_t>(outline.sides)),
        fixed_(static_cast<std::int32_t>(points.size())),
        field_(outline.loop(), line_sides(outline), config.edge_length, 4 * config.vertices),
        net_(points, sides_, outline.lines) {}

  PolygonMesh run() {
    insert_lattice();
    refine();
    for (std::int32_t i = 0; i < config_.smoothing; ++i) {
      smooth();
      net_.restore();
    }
    open_corners();
    for (int i = 0; i < 3; ++i) smooth();
    return result();
  }

 private:
  Vec2 at(std::int32_t point) const { return plane_.point(net_.points()[point]); }
  bool is_inner(std::int32_t point) const { return point >= Triangulation::kOuter + fixed_; }

  static std::vector<SizeField::Side> line_sides(const PanelOutline& outline) {
    std::vector<SizeField::Side> sides;
    for (const auto& [a, b] : outline.lines)
      sides.push_back({outline.points[a], outline.points[b]});
    return sides;
  }

  /// Points of a lattice of equilateral triangles, where the border does not ask for shorter edges.
  void insert_lattice() {
    Vec2 low = at(Triangulation::kOuter), high = low;
    for (std::int32_t i = 0; i < sides_; ++i) {
      low = low.cwiseMin(at(Triangulation::kOuter + i));
      high = high.cwiseMax(at(Triangulation::kOuter + i));
    }
    const double h = config_.edge_length, row = h * std::sqrt(0.75);
    const auto rows = static_cast<std::int64_t>((high.y() - low.y()) / row);
    const auto columns = static_cast<std::int64_t>((high.x() - low.x()) / h) + 1;
    std::int32_t near = net_.cell_of(Triangulation::kOuter);
    for (std::int64_t j = 0; j <= rows; ++j) {
      for (std::int64_t k = 0; k <= columns; ++k) {
        const std::int64_t i =
            j % 2 == 0 ? k : columns - k;  // to and fro, so that searches are short
        const Vec2 p = low + Vec2((static_cast<double>(i) + (j % 2 == 0 ? 0.25 : 0.75)) * h,
                                  (static_cast<double>(j) + 0.5) * row);
        if (p.x() >= high.x() || field_.size(p) < 0.95 * h) continue;
        if (field_.distance(p) < kLatticeClearance * h) continue;
        insert(plane_.snap(p), near);
      }
    }
  }

  std::int32_t insert(const GridPoint& p, std::int32_t& near) {
    const std::int32_t cell = net_.locate(p, near);
    if (cell == Triangulation::kNone) return cell;
    near = cell;
    const std::int32_t point = net_.insert(p, cell);
    if (point != Triangulation::kNone) near = net_.cell_of(point);
    if (static_cast<std::int64_t>(net_.points().size()) > config_.vertices)
      throw std::invalid_argument(
          fmt::format("an edge length of {:g} m gives more than {} vertices; choose a larger one",
                      config_.edge_length, config_.vertices));
    return point;
  }

  struct Coarse {
    double excess;  // radius relative to the local size
    std::int32_t cell;
    std::array<std::int32_t, 3> v;
    bool operator<(const Coarse& other) const {
      return std::pair(excess, other.cell) < std::pair(other.excess, cell);
    }
  };

  Vec2 circumcentre(const std::array<std::int32_t, 3>& v) const {
    const Vec2 a = at(v[0]), b = at(v[1]) - a, c = at(v[2]) - a;
    const double twice = 2.0 * cross(b, c);
    return a + Vec2(c.y() * b.squaredNorm() - b.y() * c.squaredNorm(),
                    b.x() * c.squaredNorm() - c.x() * b.squaredNorm()) /
                   twice;
  }

  void queue(std::int32_t cell) {
    const Triangulation::Cell& c = net_.cell(cell);
    if (!c.inside) return;
    const Vec2 centre = circumcentre(c.v);
    const Vec2 middle = (at(c.v[0]) + at(c.v[1]) + at(c.v[2])) / 3.0;
    const double excess = (centre - at(c.v[0])).norm() / field_.size(middle);
    if (excess > kCoarse) coarse_.push({excess, cell, c.v});
  }

  /// Delaunay refinement [Chew1989] with circumcentres that are clear of the border, worst first.
  void refine() {
    for (std::int32_t c = 0; c < static_cast<std::int32_t>(net_.cells().size()); ++c) queue(c);
    while (!coarse_.empty()) {
      const Coarse worst = coarse_.top();
      coarse_.pop();
      if (net_.cell(worst.cell).v != worst.v) continue;
      if (!refine_at(circumcentre(worst.v), worst.cell)) {
        const Vec2 middle = middle_of(worst.v);
        if (!is_crowded(worst.cell, middle)) refine_at(middle, worst.cell);
      }
    }
  }

  bool refine_at(const Vec2& p, std::int32_t near) {
    if (!is_within(p) || field_.distance(p) < kInsertClearance * field_.size(p)) return false;
    if (insert(plane_.snap(p), near) == Triangulation::kNone) return false;
    const std::vector<std::int32_t> changed = net_.changed();
    for (const std::int32_t c : changed) queue(c);
    return true;
  }

  /// Whether a centroid is too near a corner of its cell or of the cells beside it. A circumcentre
  /// never is, but slender cells along a long side could be divided without end.
  bool is_crowded(std::int32_t cell, const Vec2& centroid) const {
    const double least = kInsertSpacing * field_.size(centroid);
    const auto has_near = [&](std::int32_t c) {
      const auto& v = net_.cell(c).v;
      return std::any_of(v.begin(), v.end(),
                         [&](std::int32_t point) { return (at(point) - centroid).norm() < least; });
    };
    const auto& across = net_.cell(cell).across;
    return has_near(cell) || std::any_of(across.begin(), across.end(), [&](std::int32_t c) {
             return c != Triangulation::kNone && net_.cell(c).inside && has_near(c);
           });
  }

  Vec2 middle_of(const std::array<std::int32_t, 3>& v) const {
    return (at(v[0]) + at(v[1]) + at(v[2])) / 3.0;
  }

  /// Keeps far circumcentres out of the range of the grid.
  bool is_within(const Vec2& p) const {
    const Vec2 q = (p - plane_.point({0, 0})) / plane_.unit();
    return q.minCoeff() > 0.0 && q.maxCoeff() < static_cast<double>(std::int64_t(1) << 26);
  }

  /// Least angle of the cells around a point, rad; -1 if one is not counter-clockwise.
  double least_angle(const std::vector<std::int32_t>& cells) const {
    double least = std::numbers::pi;
    for (const std::int32_t c : cells) {
      const auto& v = net_.cell(c).v;
      if (turn(net_.points()[v[0]], net_.points()[v[1]], net_.points()[v[2]]) <= 0) return -1.0;
      least = std::min(least, detail::least_angle_of(at(v[0]), at(v[1]), at(v[2])));
    }
    return least;
  }

  /// Moves inner points to the mean of the centroids around them, weighted by area, and half-way if
  /// that makes an angle worse.
  void smooth() {
    std::vector<std::int32_t> cells;
    for (std::int32_t point = Triangulation::kOuter + fixed_;
         point < static_cast<std::int32_t>(net_.points().size()); ++point) {
      net_.star(point, cells);
      const GridPoint before = net_.points()[point];
      const double angle = least_angle(cells);
      const Vec2 from = at(point), target = mean_centroid(cells);
      for (const double share : {1.0, 0.5, 0.25}) {
        net_.move(point, plane_.snap(from + share * (target - from)));
        if (least_angle(cells) >= std::min(angle, kGoodAngle)) break;
        net_.move(point, before);
      }
    }
  }

  /// Weights fall with the local size, so that edges stay graded.
  Vec2 mean_centroid(const std::vector<std::int32_t>& cells) const {
    Vec2 sum = Vec2::Zero();
    double total = 0.0;
    for (const std::int32_t c : cells) {
      const auto& v = net_.cell(c).v;
      const Vec2 middle = middle_of(v);
      const double size = field_.size(middle);
      const double weight = cross(at(v[1]) - at(v[0]), at(v[2]) - at(v[0])) / (size * size * size);
      sum += weight * middle;
      total += weight;
    }
    return sum / total;
  }

  /// A cell with two sides on the border is divided, by a flip or at the middle of its third side.
  void open_corners() {
    for (std::int32_t c = 0; c < static_cast<std::int32_t>(net_.cells().size()); ++c) {
      const Triangulation::Cell& cell = net_.cell(c);
      const int fixed = cell.fixed[0] + cell.fixed[1] + cell.fixed[2];
      if (!cell.inside || fixed < 2) continue;
      if (fixed == 3) {
        std::int32_t near = c;
        insert(plane_.snap(middle_of(cell.v)), near);
        continue;
      }
      const int i = !cell.fixed[0] ? 0 : !cell.fixed[1] ? 1 : 2;
      open_corner(c, i);
    }
  }

  /// Takes the flip or the point near the third side, opposite v[i], that leaves the best angles. A
  /// flip needs an inner point beyond the side, or the cell there could get a second fixed side.
  void open_corner(std::int32_t c, int i) {
    const Triangulation::Cell& cell = net_.cell(c);
    const Triangulation::Cell& beyond = net_.cell(cell.across[i]);
    const std::int32_t apex = beyond.v[beyond.across[0] == c ? 0 : beyond.across[1] == c ? 1 : 2];
    const Vec2 top = at(cell.v[i]), bottom = at(apex);
    const Vec2 from = at(cell.v[(i + 1) % 3]), to = at(cell.v[(i + 2) % 3]);
    const auto least_of = [](const Vec2& p, const Vec2& q, const Vec2& r) {
      return cross(q - p, r - p) > 0.0 ? detail::least_angle_of(p, q, r) : -1.0;
    };
    double best = -1.0;
    if (is_inner(apex) && net_.can_flip(c, i))
      best = std::min(least_of(top, from, bottom), least_of(bottom, to, top));
    const Vec2 middle = 0.5 * (from + to);
    std::optional<GridPoint> point;
    for (const double share : {0.0, 0.1, 0.2, 0.3, 0.4, 0.5, -0.1, -0.2}) {
      const GridPoint p = plane_.snap(
          middle + share * ((share < 0.0 ? -1.0 : 1.0) * ((share < 0.0 ? top : bottom) - middle)));
      const Vec2 x = plane_.point(p);
      const double least = std::min({least_of(top, from, x), least_of(top, x, to),
                                     least_of(bottom, x, from), least_of(bottom, to, x)});
      if (least <= best) continue;
      best = least;
      point = p;
    }
    if (point)
      net_.divide(c, i, *point);
    else if (best > 0.0)
      net_.flip(c, i);
  }

  PolygonMesh result() const {
    PolygonMesh mesh;
    const auto n = static_cast<std::int32_t>(net_.points().size());
    for (std::int32_t p = Triangulation::kOuter; p < n; ++p) mesh.vertices.push_back(at(p));
    for (const Triangulation::Cell& cell : net_.cells()) {
      if (!cell.inside) continue;
      Triangle t;
      for (int i = 0; i < 3; ++i) t[i] = cell.v[i] - Triangulation::kOuter;
      std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
      mesh.triangles.push_back(t);
    }
    std::sort(mesh.triangles.begin(), mesh.triangles.end());
    return mesh;
  }

  const PanelMeshConfig& config_;
  GridPlane plane_;
  std::int32_t sides_, fixed_;  // of the loop; points that stay where they are
  SizeField field_;
  Triangulation net_;
  std::priority_queue<Coarse> coarse_;
};

}  // namespace

double detail::least_angle_of(const Vec2& a, const Vec2& b, const Vec2& c) {
  const auto angle = [](const Vec2& u, const Vec2& v) {
    return elementary::atan2(std::abs(cross(u, v)), u.dot(v));
  };
  return std::min({angle(b - a, c - a), angle(c - b, a - b), angle(a - c, b - c)});
}

PanelMeshQuality detail::quality_of(std::span<const Vec2> loop, std::span<const Vec2> vertices,
                                    std::span<const Triangle> triangles) {
  PanelMeshQuality q;
  q.vertices = static_cast<std::int64_t>(vertices.size());
  q.triangles = static_cast<std::int64_t>(triangles.size());
  std::vector<char> sharp(vertices.size(), 0);
  const double half_turn = std::numbers::pi;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2& p = loop[i];
    const Vec2 u = loop[(i + loop.size() - 1) % loop.size()] - p,
               v = loop[(i + 1) % loop.size()] - p;
    sharp[i] = elementary::acos(std::clamp(u.normalized().dot(v.normalized()), -1.0, 1.0)) <
               half_turn / 3.0;
  }
  q.least_angle = q.least_free_angle = half_turn;
  for (const Triangle& t : triangles) {
    const Vec2 &a = vertices[t[0]], &b = vertices[t[1]], &c = vertices[t[2]];
    const double least = detail::least_angle_of(a, b, c);
    q.area += 0.5 * cross(b - a, c - a);
    q.least_angle = std::min(q.least_angle, least);
    if (!sharp[t[0]] && !sharp[t[1]] && !sharp[t[2]])
      q.least_free_angle = std::min(q.least_free_angle, least);
    q.mean_least_angle += least / static_cast<double>(triangles.size());
  }
  const std::vector<Edge> edges = unique_edges(triangles);
  for (const Edge& e : edges) {
    const double length = (vertices[e[0]] - vertices[e[1]]).norm();
    q.shortest = q.shortest == 0.0 ? length : std::min(q.shortest, length);
    q.longest = std::max(q.longest, length);
    q.mean += length / static_cast<double>(edges.size());
  }
  return q;
}

PolygonMesh mesh_polygon(std::span<const Vec2> loop, const PanelMeshConfig& config) {
  return mesh_outline({{loop.begin(), loop.end()}, loop.size(), {}}, config);
}

PolygonMesh mesh_outline(const PanelOutline& outline, const PanelMeshConfig& config) {
  const std::span<const Vec2> loop = outline.loop();
  require(config.edge_length > 0.0 && std::isfinite(config.edge_length), "edge_length",
          config.edge_length, "positive and finite");
  require(config.smoothing >= 0, "smoothing", config.smoothing, "at least 0");
  if (loop.size() < 3) throw std::invalid_argument("the loop has fewer than three points");
  for (std::size_t i = 0; i < loop.size(); ++i)
    if (!loop[i].allFinite() || loop[i].cwiseAbs().maxCoeff() > 1e9)
      throw std::invalid_argument(
          fmt::format("point {} of the loop is not finite or beyond 1e9 m", i));
  const GridPlane plane(loop);
  std::vector<GridPoint> points;
  for (const Vec2& p : outline.points) points.push_back(plane.snap(p));
  if (const auto crossing = detail::loop_crossing(std::span(points).first(outline.sides)))
    throw std::invalid_argument(
        fmt::format("the loop crosses or touches itself at its sides {} and {}", crossing->first,
                    crossing->second));
  const auto sides = static_cast<std::int32_t>(outline.sides);
  if (const auto crossing = detail::line_crossing(points, sides, outline.lines)) {
    const auto [a, b] = outline.lines[static_cast<std::size_t>(*crossing)];
    throw std::invalid_argument(
        fmt::format("the line from ({:g}, {:g}) to ({:g}, {:g}) m meets the loop or another line "
                    "between its ends",
                    outline.points[a].x(), outline.points[a].y(), outline.points[b].x(),
                    outline.points[b].y()));
  }
  PolygonMesh mesh = PolygonMesher(outline, config, plane, points).run();
  mesh.quality = detail::quality_of(loop, mesh.vertices, mesh.triangles);
  return mesh;
}

}  // namespace selvedge
