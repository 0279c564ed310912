// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/garment/detail/grid_plane.h>
#include <selvedge/garment/detail/pattern_names.h>
#include <selvedge/garment/detail/side_parity.h>
#include <selvedge/garment/sewing_pattern.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>

namespace selvedge {
namespace {

using detail::edge_name;
using detail::quoted;
using Side = PatternStitch::Side;

/// Points of a curved edge for the check of its loop.
constexpr std::int32_t kCheckPieces = 24;
/// Samples along each axis for the overlap of two panels.
constexpr std::int32_t kOverlapSamples = 24;
/// Panels are in one plane if they are nearer than this, m.
constexpr double kSamePlane = 1e-3;
/// Cosine of the angle above which one edge runs along another.
constexpr double kAlong = 0.5;
/// Share of the twisted edges of a panel, beside which those that fit do not count: edges of a few
/// millimetres at the corners of armholes point anywhere.
constexpr double kStray = 0.1;

std::int32_t size_of(const auto& list) { return static_cast<std::int32_t>(list.size()); }

struct Loop {
  std::vector<Vec2> points;
  std::vector<std::int32_t> edge;  // edge of the side that starts at the point
};

Loop loop_of(const PatternPanel& panel) {
  Loop loop;
  for (std::int32_t e = 0; e < size_of(panel.edges); ++e) {
    const PatternCurve& curve = panel.edges[e].curve;
    const bool straight = curve.kind == PatternCurve::Kind::straight;
    std::vector<Vec2> points = divide_edge(panel, e, straight ? 1 : kCheckPieces);
    if (curve.kind == PatternCurve::Kind::polyline) {
      points = {points.front(), points.back()};
      points.insert(points.begin() + 1, curve.through.begin(), curve.through.end());
    }
    loop.points.insert(loop.points.end(), points.begin(), points.end() - 1);
    loop.edge.resize(loop.points.size(), e);
  }
  return loop;
}

bool contains(const std::vector<Vec2>& loop, const Vec2& p) {
  bool inside = false;
  for (std::size_t i = 0, j = loop.size() - 1; i < loop.size(); j = i++) {
    const Vec2 &a = loop[i], &b = loop[j];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
  }
  return inside;
}

class PatternCheck {
 public:
  PatternCheck(const SewingPattern& pattern, const PatternLimits& limits)
      : pattern_(pattern), limits_(limits) {}

  void run() {
    check_names();
    for (const PatternPanel& panel : pattern_.panels) check_panel(panel);
    check_stitches();
    if (!limits_.places) return;
    check_sides();
    check_places();
  }

 private:
  [[noreturn]] void refuse(const std::string& fault) const {
    throw std::invalid_argument(fmt::format("{}: {}", pattern_.name, fault));
  }
  [[noreturn]] void refuse(const PatternPanel& panel, const std::string& fault) const {
    refuse(fmt::format("panel {}: {}", quoted(panel.name), fault));
  }
  [[noreturn]] void refuse(std::int32_t stitch, const std::string& fault) const {
    refuse(fmt::format("stitch {}: {}", stitch, fault));
  }

  void check_names() const {
    if (pattern_.panels.empty()) refuse("has no panels; a garment needs at least one");
    std::set<std::string> names;
    for (const PatternPanel& panel : pattern_.panels)
      if (!names.insert(panel.name).second)
        refuse(panel, "there are two panels of this name; rename one");
  }

  void check_panel(const PatternPanel& panel) {
    check_numbers(panel);
    check_loop(panel);
    for (std::int32_t e = 0; e < size_of(panel.edges); ++e) check_edge(panel, e);
    loops_.push_back(loop_of(panel));
    check_extent(panel, loops_.back());
    check_crossing(panel, loops_.back());
    check_lines(panel, loops_.back());
    check_area(panel, loops_.back());
  }

  void check_numbers(const PatternPanel& panel) const {
    const auto bounded = [&](const auto& v) {
      return v.allFinite() && v.cwiseAbs().maxCoeff() <= limits_.largest;
    };
    for (std::int32_t i = 0; i < size_of(panel.vertices); ++i)
      if (!bounded(panel.vertices[i]))
        refuse(panel,
               fmt::format("vertex {} is ({:g}, {:g}) m, which is beyond {:g} m; check "
                           "units_in_meter and the vertex",
                           i, panel.vertices[i].x(), panel.vertices[i].y(), limits_.largest));
    if (!bounded(panel.translation))
      refuse(panel, fmt::format("its translation is beyond {:g} m; check units_in_meter and the "
                                "translation",
                                limits_.largest));
    if (!std::isfinite(panel.bend.radius) ||
        (panel.bend.radius != 0.0 && std::abs(panel.bend.radius) < limits_.smallest))
      refuse(panel, fmt::format("is bent with a radius of {:g} m; give 0 or at least {:g} m",
                                panel.bend.radius, limits_.smallest));
    const Mat3 rest = panel.rotation * panel.rotation.transpose() - Mat3::Identity();
    if (!(rest.cwiseAbs().maxCoeff() < 1e-9) ||
        panel.rotation.col(0).cross(panel.rotation.col(1)).dot(panel.rotation.col(2)) < 0.0)
      refuse(panel, "its rotation is not a rotation; give three finite angles in degrees");
  }

  void check_loop(const PatternPanel& panel) const {
    const std::int32_t n = size_of(panel.edges);
    if (n < 2)
      refuse(panel, fmt::format("has {}; a closed loop needs at least two", counted(n, "edge")));
    std::vector<std::int32_t> uses(panel.vertices.size(), 0);
    std::vector<char> is_on_line(panel.vertices.size(), 0);
    for (std::int32_t l = 0; l < size_of(panel.lines); ++l)
      for (const std::int32_t v : panel.lines[l].endpoints) {
        if (v < 0 || v >= size_of(panel.vertices))
          refuse(panel, fmt::format("line {} names vertex {}, but the panel has {} vertices; "
                                    "correct its endpoints",
                                    l, v, panel.vertices.size()));
        is_on_line[v] = 1;
      }
    for (std::int32_t e = 0; e < n; ++e) {
      const auto [start, end] = panel.edges[e].endpoints;
      for (const std::int32_t v : {start, end})
        if (v < 0 || v >= size_of(panel.vertices))
          refuse(panel, fmt::format("edge {} names vertex {}, but the panel has {} vertices; "
                                    "correct its endpoints",
                                    e, v, panel.vertices.size()));
      if (start == end)
        refuse(panel, fmt::format("edge {} starts and ends at vertex {}; give it two different "
                                  "endpoints",
                                  e, start));
      ++uses[start];
    }
    for (std::int32_t e = 0; e < n; ++e) {
      const std::int32_t next = (e + 1) % n;
      if (panel.edges[e].endpoints[1] != panel.edges[next].endpoints[0])
        refuse(panel,
               fmt::format("the loop is open: edge {} ends at vertex {}, but edge {} starts "
                           "at vertex {}; list the edges in order around the panel",
                           e, panel.edges[e].endpoints[1], next, panel.edges[next].endpoints[0]));
    }
    for (std::int32_t v = 0; v < size_of(uses); ++v) {
      if (uses[v] > 1)
        refuse(panel, fmt::format("the loop passes vertex {} {} times; give each passage a vertex "
                                  "of its own, apart from the other",
                                  v, uses[v]));
      if (uses[v] == 0 && !is_on_line[v])
        refuse(panel, fmt::format("vertex {} is on no edge; remove it, or add its edges", v));
    }
  }

  void check_elastic(const PatternPanel& panel, std::int32_t edge,
                     const PatternElastic& elastic) const {
    if (elastic.ratio == 0.0) return;
    const bool is_line = panel.is_line(edge);
    const std::string name = fmt::format("the elastic of {} {}", is_line ? "line" : "edge",
                                         edge - (is_line ? size_of(panel.edges) : 0));
    if (!(elastic.ratio > 0.0) || elastic.ratio > 1.0)
      refuse(panel, fmt::format("{} has the ratio {:g}; give its rest length over that of the "
                                "cloth, above 0 and at most 1",
                                name, elastic.ratio));
    if (!(elastic.stiffness > 0.0) || !std::isfinite(elastic.stiffness))
      refuse(panel, fmt::format("{} has the stiffness {:g}; give newtons above 0", name,
                                elastic.stiffness));
  }

  /// Lines stay inside the loop and apart from each other, so that a mesh can have them.
  void check_lines(const PatternPanel& panel, const Loop& loop) const {
    if (panel.lines.empty()) return;
    const detail::GridPlane plane(loop.points);
    std::vector<detail::GridPoint> points;
    for (const Vec2& p : loop.points) points.push_back(plane.snap(p));
    std::map<std::int32_t, std::int32_t> point_of;
    for (std::int32_t i = 0; i < size_of(loop.points); ++i)
      if (i == 0 || loop.edge[i] != loop.edge[i - 1])
        point_of[panel.edges[loop.edge[i]].endpoints[0]] = i;
    std::vector<std::array<std::int32_t, 2>> lines;
    for (std::int32_t l = 0; l < size_of(panel.lines); ++l) {
      const PatternLine& line = panel.lines[l];
      auto& ends = lines.emplace_back();
      for (const int i : {0, 1}) {
        const auto [at, is_new] = point_of.try_emplace(line.endpoints[i], size_of(points));
        if (is_new) points.push_back(plane.snap(panel.vertices[line.endpoints[i]]));
        ends[i] = at->second;
      }
      const Vec2 middle =
          0.5 * (panel.vertices[line.endpoints[0]] + panel.vertices[line.endpoints[1]]);
      if (!contains(loop.points, middle))
        refuse(panel, fmt::format("line {} lies outside its loop; correct its endpoints", l));
      check_elastic(panel, size_of(panel.edges) + l, line.elastic);
      if (line.angle && !(std::abs(*line.angle) < std::numbers::pi))
        refuse(panel, fmt::format("line {} is folded by {:g} degrees; give an angle above -180 and "
                                  "below 180",
                                  l, *line.angle * 180.0 / std::numbers::pi));
      if (!(line.stiffness > 0.0) || !std::isfinite(line.stiffness))
        refuse(panel, fmt::format("line {} has the stiffness {:g}; give newtons above 0", l,
                                  line.stiffness));
    }
    if (const auto crossing = detail::line_crossing(points, size_of(loop.points), lines))
      refuse(panel, fmt::format("line {} meets the loop or another line between its ends; divide "
                                "both there, or move its endpoints",
                                *crossing));
  }

  void check_edge(const PatternPanel& panel, std::int32_t edge) const {
    check_elastic(panel, edge, panel.edges[edge].elastic);
    const PatternCurve& curve = panel.edges[edge].curve;
    for (const Vec2& p : curve.control)
      if (!p.allFinite() || p.cwiseAbs().maxCoeff() > 4.0 * limits_.largest)
        refuse(panel, fmt::format("edge {} has a control point beyond {:g} m; check its curvature",
                                  edge, 4.0 * limits_.largest));
    for (const Vec2& p : curve.through)
      if (!p.allFinite() || p.cwiseAbs().maxCoeff() > limits_.largest)
        refuse(panel, fmt::format("edge {} has a point beyond {:g} m; check units_in_meter", edge,
                                  limits_.largest));
    const Vec2 chord = panel.vertices[panel.edges[edge].endpoints[1]] -
                       panel.vertices[panel.edges[edge].endpoints[0]];
    if (chord.norm() < 1e-3 * limits_.smallest)
      refuse(panel, fmt::format("edge {} has no length; merge its vertices {} and {}", edge,
                                panel.edges[edge].endpoints[0], panel.edges[edge].endpoints[1]));
    if (curve.kind != PatternCurve::Kind::arc) return;
    if (!(curve.radius >= 0.5 * chord.norm() * (1.0 - 1e-6)) ||
        curve.radius > 1e3 * limits_.largest)
      refuse(panel,
             fmt::format("edge {} is an arc of radius {:g} m, but its ends are {:g} m apart; "
                         "the radius must be between half that distance and {:g} m",
                         edge, curve.radius, chord.norm(), 1e3 * limits_.largest));
  }

  Vec2 extent(const Loop& loop) const {
    Vec2 low = loop.points[0], high = loop.points[0];
    for (const Vec2& p : loop.points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    return high - low;
  }

  void check_extent(const PatternPanel& panel, const Loop& loop) const {
    if (extent(loop).minCoeff() < limits_.smallest) refuse_size(panel, extent(loop));
  }

  /// A loop that crosses itself may have none, so this comes last.
  void check_area(const PatternPanel& panel, const Loop& loop) const {
    const Vec2 size = extent(loop);
    if (std::abs(panel_area(panel)) < 1e-3 * limits_.smallest * size.maxCoeff())
      refuse_size(panel, size);
  }

  [[noreturn]] void refuse_size(const PatternPanel& panel, const Vec2& size) const {
    refuse(panel, fmt::format("it is {:g} m by {:g} m with an area of {:g} m2; a panel needs area; "
                              "check units_in_meter and its vertices",
                              size.x(), size.y(), std::abs(panel_area(panel))));
  }

  void check_crossing(const PatternPanel& panel, const Loop& loop) const {
    const detail::GridPlane plane(loop.points);
    std::vector<detail::GridPoint> points;
    for (const Vec2& p : loop.points) points.push_back(plane.snap(p));
    const auto crossing = detail::loop_crossing(points);
    if (!crossing) return;
    const std::int32_t a = loop.edge[crossing->first], b = loop.edge[crossing->second];
    if (a == b) refuse(panel, fmt::format("edge {} crosses itself; change its curvature", a));
    refuse(panel, fmt::format("the loop crosses itself: edge {} meets edge {}; move their vertices "
                              "or change their curvature",
                              a, b));
  }

  void check_stitches() const {
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> sewn;
    std::vector<char> stitched(pattern_.panels.size(), 0);
    for (std::int32_t s = 0; s < size_of(pattern_.stitches); ++s) {
      for (const Side& side : {pattern_.stitches[s].a, pattern_.stitches[s].b}) {
        check_side(s, side);
        const auto [at, fresh] = sewn.insert({{side.panel, side.edge}, s});
        if (!fresh)
          refuse(s, fmt::format("{} is already in stitch {}; an edge can be sewn once: remove one "
                                "stitch or divide the edge",
                                edge_name(pattern_, side), at->second));
        stitched[side.panel] = 1;
      }
      check_lengths(s);
      check_closure(s);
    }
    for (std::size_t p = 0; pattern_.panels.size() > 1 && p < stitched.size(); ++p)
      if (!stitched[p])
        refuse(pattern_.panels[p], "no stitch holds it; add a stitch or remove the panel");
  }

  void check_side(std::int32_t stitch, const Side& side) const {
    const std::int32_t panels = size_of(pattern_.panels);
    if (side.panel < 0 || side.panel >= panels)
      refuse(stitch, fmt::format("names panel {}, but there {} {}", side.panel,
                                 panels == 1 ? "is" : "are", counted(panels, "panel")));
    const PatternPanel& panel = pattern_.panels[side.panel];
    if (side.edge < 0 || side.edge >= size_of(panel.edges) + size_of(panel.lines))
      refuse(stitch, fmt::format("names edge {} of panel {}, which has the edges 0 to {}; correct "
                                 "the edge",
                                 side.edge, quoted(panel.name), size_of(panel.edges) - 1));
  }

  void check_closure(std::int32_t s) const {
    const PatternStitch& stitch = pattern_.stitches[s];
    const bool has_buttons = stitch.closure == PatternStitch::Closure::buttons;
    if (has_buttons == stitch.buttons.empty())
      refuse(s, has_buttons ? "is closed by buttons, but has none; give their number or places"
                            : "has buttons, but is not closed by them");
    for (const double share : stitch.buttons)
      if (!(share >= 0.0 && share <= 1.0))
        refuse(s,
               fmt::format("has a button at {:g}; give shares of its length from 0 to 1", share));
  }

  void check_lengths(std::int32_t s) const {
    const PatternStitch& stitch = pattern_.stitches[s];
    const double a = edge_length(pattern_.panels[stitch.a.panel], stitch.a.edge);
    const double b = edge_length(pattern_.panels[stitch.b.panel], stitch.b.edge);
    if (std::max(a, b) > limits_.length_ratio * std::min(a, b))
      refuse(s, fmt::format("{} is {:.4g} m long, but {} is {:.4g} m; the longer may have at most "
                            "{:g} times the length of the shorter: change an edge or the stitch",
                            edge_name(pattern_, stitch.a), a, edge_name(pattern_, stitch.b), b,
                            limits_.length_ratio));
  }

  /// Directed chord of a side of a seam, as its panel stands, m.
  Vec3 chord(const Side& side) const {
    const PatternPanel& panel = pattern_.panels[side.panel];
    const auto [start, end] = panel.endpoints(side.edge);
    return place_point(panel, panel.vertices[end]) - place_point(panel, panel.vertices[start]);
  }

  /// Edges of seams to other panels that run along the edge they are sewn to, as the panels stand:
  /// those that the file joins end to end that way, and the other way round.
  struct SeamsOfPanel {
    double fitting = 0.0, twisted = 0.0;  // m of edges
    int count = 0;                        // of all seams to others, whatever their angle
    std::vector<std::int32_t> list;       // the twisted stitches
  };

  /// How far two edges are apart does not matter for it, unlike for the distances of their ends.
  std::vector<SeamsOfPanel> seams_of_panels() const {
    std::vector<SeamsOfPanel> seams(pattern_.panels.size());
    for (std::int32_t s = 0; s < size_of(pattern_.stitches); ++s) {
      const PatternStitch& stitch = pattern_.stitches[s];
      // A panel may lie on either side of a line.
      if (stitch.direction == PatternStitch::Direction::unknown ||
          stitch.a.panel == stitch.b.panel || pattern_.is_on_a_line(stitch))
        continue;
      for (const std::int32_t p : {stitch.a.panel, stitch.b.panel}) ++seams[p].count;
      const Vec3 a = chord(stitch.a), b = chord(stitch.b);
      const double length = std::sqrt(a.norm() * b.norm()), cosine = a.dot(b) / (length * length);
      if (!(std::abs(cosine) >= kAlong)) continue;  // also a chord without length
      const bool is_twisted =
          (cosine > 0.0) != (stitch.direction == PatternStitch::Direction::start_to_start);
      for (const std::int32_t p : {stitch.a.panel, stitch.b.panel}) {
        (is_twisted ? seams[p].twisted : seams[p].fitting) += length;
        if (is_twisted) seams[p].list.push_back(s);
      }
    }
    return seams;
  }

  /// A panel whose seams to others are twisted as the panels stand, although the file says which
  /// ends meet, has its loop the wrong way round. Of several, the one that faces most inward. One
  /// that hangs by a single seam can turn about it.
  void check_sides() const {
    const std::vector<SeamsOfPanel> seams = seams_of_panels();
    const std::vector<double> outward = detail::outward_faces(pattern_);
    std::int32_t found = -1;
    for (std::int32_t p = 0; p < size_of(seams); ++p)
      if (seams[p].count > 1 && !seams[p].list.empty() &&
          seams[p].fitting <= kStray * seams[p].twisted &&
          (found < 0 || outward[p] < outward[found]))
        found = p;
    if (found < 0) return;
    refuse(fmt::format(
        "panel {} {}: its seams are twisted as the panels stand (stitches {}); list its edges the "
        "other way round, or turn the panel over",
        quoted(pattern_.panels[found].name),
        panel_area(pattern_.panels[found]) < 0.0 ? "runs clockwise" : "shows its inner side",
        fmt::join(seams[found].list, ", ")));
  }

  void check_places() const {
    for (std::int32_t a = 0; a < size_of(pattern_.panels); ++a)
      for (std::int32_t b = a + 1; b < size_of(pattern_.panels); ++b)
        if (const double share = std::max(covered(a, b), covered(b, a)); share > limits_.overlap)
          refuse(fmt::format(
              "panels {} and {} stand in one place: {:.0f} % of one lies in the other; "
              "change the rotation or translation of one, or place all with `selvedge arrange`",
              quoted(pattern_.panels[a].name), quoted(pattern_.panels[b].name), 100.0 * share));
  }

  /// Share of panel b that lies within panel a, 0 unless both are in one plane.
  double covered(std::int32_t a, std::int32_t b) const {
    const PatternPanel &under = pattern_.panels[a], &over = pattern_.panels[b];
    if (std::abs(under.rotation.col(2).dot(over.rotation.col(2))) < 1.0 - 1e-6) return 0.0;
    const auto seen = [&](const Vec2& p) -> Vec3 {
      return under.rotation.transpose() * (place_point(over, p) - under.translation);
    };
    Vec2 low = loops_[b].points[0], high = low;
    for (const Vec2& p : loops_[b].points) {
      if (std::abs(seen(p).z()) > kSamePlane) return 0.0;
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    std::int32_t all = 0, both = 0;
    for (std::int32_t i = 0; i < kOverlapSamples * kOverlapSamples; ++i) {
      const Vec2 part((i % kOverlapSamples + 0.5) / kOverlapSamples,
                      (static_cast<double>(i / kOverlapSamples) + 0.5) / kOverlapSamples);
      const Vec2 p = low + part.cwiseProduct(high - low);
      if (!contains(loops_[b].points, p)) continue;
      ++all;
      if (contains(loops_[a].points, seen(p).head<2>())) ++both;
    }
    return all == 0 ? 0.0 : static_cast<double>(both) / all;
  }

  const SewingPattern& pattern_;
  const PatternLimits& limits_;
  std::vector<Loop> loops_;
};

}  // namespace

void check_sewing_pattern(const SewingPattern& pattern, const PatternLimits& limits) {
  PatternCheck(pattern, limits).run();
}

}  // namespace selvedge
