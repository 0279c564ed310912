// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/check.h>
#include <selvedge/garment/detail/mirror_mesh.h>
#include <selvedge/garment/detail/panel_quality.h>
#include <selvedge/garment/detail/pattern_names.h>
#include <selvedge/garment/detail/short_edges.h>
#include <selvedge/garment/detail/side_parity.h>
#include <selvedge/garment/panel_mesh.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace selvedge {
namespace {

/// A side of the border turns by at most this angle along a curve, rad.
constexpr double kTurnPerSide = std::numbers::pi / 6.0;
/// Volume of a garment about its middle, relative to its area to the power of 3/2, below which it
/// has no outside.
constexpr double kFlat = 1e-3;

std::int32_t count_of(const auto& list) { return static_cast<std::int32_t>(list.size()); }

/// Number of sides into which each edge of each panel is divided; 0 for one that is joined.
std::vector<std::vector<std::int32_t>> divisions(const SewingPattern& pattern,
                                                 const PanelMeshConfig& config,
                                                 const detail::ShortEdges& short_edges) {
  std::vector<std::vector<std::int32_t>> pieces;
  for (std::int32_t p = 0; p < count_of(pattern.panels); ++p) {
    const PatternPanel& panel = pattern.panels[p];
    std::vector<std::int32_t>& of_panel = pieces.emplace_back();
    const std::int32_t edges = count_of(panel.edges);
    for (std::int32_t e = 0; e < edges + count_of(panel.lines); ++e) {
      if (!panel.is_line(e) && short_edges.is_joined(p, e)) {
        of_panel.push_back(0);
        continue;
      }
      const double wanted = edge_length(panel, e) / config.edge_length;
      if (!(wanted < static_cast<double>(config.vertices)))
        throw std::invalid_argument(fmt::format(
            "{}: panel {}: edge {} needs more than {} vertices at an edge length of {:g} m; choose "
            "a "
            "larger one",
            pattern.name, detail::quoted(panel.name), e, config.vertices, config.edge_length));
      const double turns = edge_turning(panel, e) / kTurnPerSide;
      const double least = edges < 3 && !panel.is_line(e) ? 2.0 : 1.0;
      of_panel.push_back(static_cast<std::int32_t>(
          std::max({least, std::ceil(wanted - 1e-6), std::ceil(std::min(turns, 100.0) - 1e-6)})));
    }
  }
  for (const PatternStitch& s : pattern.stitches) {
    std::int32_t &a = pieces[s.a.panel][s.a.edge], &b = pieces[s.b.panel][s.b.edge];
    a = b = std::max(a, b);
  }
  return pieces;
}

/// Which panels turn their outer side away from the side that their loop gives, so that the whole
/// garment faces outward.
class OuterSides {
 public:
  OuterSides(const SewingPattern& pattern, const std::vector<SeamDirection>& directions)
      : pattern_(pattern), sides_(pattern.panels.size()) {
    for (std::size_t s = 0; s < directions.size(); ++s) {
      const PatternStitch& stitch = pattern.stitches[s];
      if (!pattern.is_on_a_line(stitch) &&
          !sides_.join(stitch.a.panel, stitch.b.panel, directions[s].start_to_start))
        one_sided_.push_back(static_cast<std::int32_t>(s));
    }
  }

  std::vector<char> turned() const {
    const std::int32_t n = count_of(pattern_.panels);
    std::vector<Vec3> middle(n, Vec3::Zero()), centroid(n), area(n);
    std::vector<double> weight(n, 0.0);
    for (std::int32_t p = 0; p < n; ++p) {
      const PatternPanel& panel = pattern_.panels[p];
      Vec2 mean = Vec2::Zero();
      for (const Vec2& v : panel.vertices) mean += v / static_cast<double>(panel.vertices.size());
      centroid[p] = place_point(panel, mean);
      area[p] = panel_area(panel) * panel.rotation.col(2);  // towards the side that the loop gives
      middle[sides_.root(p)] += area[p].norm() * centroid[p];
      weight[sides_.root(p)] += area[p].norm();
    }
    std::vector<double> volume(n, 0.0);
    for (std::int32_t p = 0; p < n; ++p) {
      const std::int32_t root = sides_.root(p);
      const double sign = sides_.is_odd(p) ? -1.0 : 1.0;
      volume[root] += sign * area[p].dot(centroid[p] - middle[root] / weight[root]);
    }
    std::vector<char> turned(n);
    for (std::int32_t p = 0; p < n; ++p) {
      const std::int32_t root = sides_.root(p);
      const bool inward = volume[root] < -kFlat * weight[root] * std::sqrt(weight[root]);
      turned[p] = static_cast<char>(sides_.is_odd(p) != inward);
    }
    return turned;
  }

  const std::vector<std::int32_t>& one_sided() const { return one_sided_; }

 private:
  const SewingPattern& pattern_;
  detail::SideParity sides_;
  std::vector<std::int32_t> one_sided_;
};

/// Between the least and the greatest x of its corners as they stand, m.
double middle_of(const SewingPattern& pattern) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const PatternPanel& panel : pattern.panels)
    for (const Vec2& v : panel.vertices) {
      const double x = place_point(panel, v).x();
      low = std::min(low, x);
      high = std::max(high, x);
    }
  return 0.5 * (low + high);
}

class GarmentMesher {
 public:
  GarmentMesher(const SewingPattern& pattern, const PanelMeshConfig& config,
                const detail::ShortEdges& short_edges)
      : pattern_(pattern),
        config_(config),
        short_edges_(short_edges),
        middle_(middle_of(pattern)) {}

  GarmentMesh run() {
    mesh_.name = pattern_.name;
    mesh_.notes = short_edges_.notes();
    const std::vector<SeamDirection> directions = seam_directions(pattern_);
    const OuterSides sides(pattern_, directions);
    const std::vector<char> turned = sides.turned();
    const auto pieces = divisions(pattern_, config_, short_edges_);
    for (std::int32_t p = 0; p < count_of(pattern_.panels); ++p) {
      const bool mirror = (panel_area(pattern_.panels[p]) < 0.0) != (turned[p] != 0);
      if (turned[p])
        mesh_.notes.push_back(
            fmt::format("panel {} is turned over: its seams put the side that its "
                        "loop shows inward",
                        detail::quoted(pattern_.panels[p].name)));
      add_panel(p, pieces[p], mirror);
    }
    mesh_.first_vertex.push_back(count_of(mesh_.placed));
    mesh_.first_triangle.push_back(count_of(mesh_.flat.triangles));
    for (std::int32_t s = 0; s < count_of(directions); ++s) add_stitch(s, directions[s]);
    for (const std::int32_t s : sides.one_sided())
      mesh_.notes.push_back(
          fmt::format("{}: it joins the outer side of one panel to the inner side "
                      "of the other, as the other seams stand",
                      mesh_.stitches[s].name));
    collect_labels();
    for (std::int32_t p = 0; p < count_of(pattern_.panels); ++p) collect_lines(p);
    mesh_.quality = total_quality();
    return std::move(mesh_);
  }

 private:
  void add_panel(std::int32_t p, const std::vector<std::int32_t>& pieces, bool mirror) {
    const PatternPanel& panel = pattern_.panels[p];
    std::vector<Vec2> loop;
    const std::int32_t first = count_of(mesh_.placed);
    std::vector<std::int32_t> starts;
    for (std::int32_t e = 0; e < count_of(panel.edges); ++e) {
      starts.push_back(count_of(loop));
      if (pieces[e] == 0) continue;
      const std::vector<Vec2> points = short_edges_.divide(p, e, pieces[e]);
      loop.insert(loop.end(), points.begin(), points.end() - 1);
    }
    add_edges(starts, pieces, first, count_of(loop));
    PanelOutline outline{std::move(loop), 0, {}};
    outline.sides = outline.points.size();
    add_lines(p, pieces, outline);
    meshed_.push_back(mesh_panel(panel, std::move(outline)));
    const PolygonMesh& polygon = meshed_.back().mesh;
    mesh_.first_vertex.push_back(first);
    mesh_.first_triangle.push_back(count_of(mesh_.flat.triangles));
    mesh_.panel_names.push_back(panel.name);
    mesh_.mirrored.push_back(static_cast<char>(mirror));
    mesh_.panel_quality.push_back(polygon.quality);
    append(polygon, p, first, mirror);
  }

  /// Divides the lines of a panel. Their ends are corners of the loop, or points inside.
  void add_lines(std::int32_t p, const std::vector<std::int32_t>& pieces, PanelOutline& outline) {
    const PatternPanel& panel = pattern_.panels[p];
    const std::int32_t edges = count_of(panel.edges), first = count_of(mesh_.placed);
    std::map<std::int32_t, std::int32_t> point_of;  // of the ends, vertices of the panel
    for (std::int32_t e = 0; e < edges; ++e)
      point_of[panel.edges[e].endpoints[0]] = mesh_.edge_vertices[p][e].front() - first;
    auto& of_panel = mesh_.line_vertices.emplace_back();
    for (std::int32_t l = 0; l < count_of(panel.lines); ++l) {
      const std::vector<Vec2> points = divide_edge(panel, edges + l, pieces[edges + l]);
      auto& vertices = of_panel.emplace_back();
      for (std::size_t i = 0; i < points.size(); ++i) {
        std::int32_t point = count_of(outline.points);
        if (i == 0 || i + 1 == points.size())
          point =
              point_of.try_emplace(panel.lines[l].endpoints[i == 0 ? 0 : 1], point).first->second;
        if (point == count_of(outline.points)) outline.points.push_back(points[i]);
        if (i > 0) outline.lines.push_back({vertices.back() - first, point});
        vertices.push_back(first + point);
      }
    }
  }

  /// A panel that is its own mirror image, or that of one before it, gets such a mesh.
  detail::MeshedPanel mesh_panel(const PatternPanel& panel, PanelOutline outline) {
    detail::MeshedPanel meshed{std::move(outline), {}, {}};
    for (const Vec2& p : meshed.outline.loop()) meshed.placed.push_back(place_point(panel, p));
    const Vec2 across = (panel.rotation.transpose() * Vec3::UnitX()).head<2>();
    std::optional<detail::MirrorMesh> made =
        detail::mesh_of_halves(meshed.outline, across, config_);
    if (!made)
      made = detail::mesh_of_image(meshed.outline, meshed.placed, meshed_, middle_, config_);
    if (made) {
      add_image(*made);
      meshed.mesh = std::move(made->mesh);
    } else {
      meshed.mesh = mesh_alone(panel, meshed.outline);
      mesh_.image.resize(mesh_.image.size() + meshed.mesh.vertices.size(), -1);
    }
    return meshed;
  }

  void add_image(const detail::MirrorMesh& made) {
    const std::int32_t first = count_of(mesh_.image),
                       of = made.panel < 0 ? first : mesh_.first_vertex[made.panel];
    for (const std::int32_t v : made.image) mesh_.image.push_back(of + v);
    for (std::int32_t v = first; v < count_of(mesh_.image); ++v) mesh_.image[mesh_.image[v]] = v;
  }

  PolygonMesh mesh_alone(const PatternPanel& panel, const PanelOutline& outline) const {
    try {
      return mesh_outline(outline, config_);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("{}: panel {}: {} at an edge length of {:g} m",
                                              pattern_.name, detail::quoted(panel.name),
                                              error.what(), config_.edge_length));
    }
  }

  void add_edges(const std::vector<std::int32_t>& starts, const std::vector<std::int32_t>& pieces,
                 std::int32_t first, std::int32_t around) {
    auto& of_panel = mesh_.edge_vertices.emplace_back();
    for (std::size_t e = 0; e < starts.size(); ++e) {
      auto& vertices = of_panel.emplace_back();
      for (std::int32_t i = 0; i <= pieces[e]; ++i)
        vertices.push_back(first + (starts[e] + i) % around);
    }
  }

  void append(const PolygonMesh& polygon, std::int32_t p, std::int32_t first, bool mirror) {
    const double sign = mirror ? -1.0 : 1.0;
    double left = sign * polygon.vertices[0].x(), right = left, low = polygon.vertices[0].y();
    for (const Vec2& v : polygon.vertices) {
      left = std::min(left, sign * v.x());
      right = std::max(right, sign * v.x());
      low = std::min(low, v.y());
    }
    for (const Vec2& v : polygon.vertices) {
      mesh_.flat.vertices.emplace_back(sign * v.x() - left + next_x_, v.y() - low, 0.0);
      mesh_.placed.push_back(place_point(pattern_.panels[p], v));
      mesh_.panel_of_vertex.push_back(p);
    }
    next_x_ += right - left + config_.gap;
    for (Triangle t : polygon.triangles) {
      if (mirror) std::swap(t[1], t[2]);
      mesh_.flat.triangles.push_back({first + t[0], first + t[1], first + t[2]});
      mesh_.panel_of_triangle.push_back(p);
    }
  }

  const std::vector<std::int32_t>& vertices_of(const PatternStitch::Side& side) const {
    const std::int32_t line = side.edge - count_of(pattern_.panels[side.panel].edges);
    return line < 0 ? mesh_.edge_vertices[side.panel][side.edge]
                    : mesh_.line_vertices[side.panel][line];
  }

  /// The pairs of a stitch that are nearest to its buttons, ascending.
  static std::vector<std::int32_t> buttons_of(const PatternStitch& stitch,
                                              const GarmentMesh::Stitch& made) {
    std::vector<std::int32_t> pairs;
    for (const double share : stitch.buttons)
      pairs.push_back(static_cast<std::int32_t>(std::lround(share * (count_of(made.a) - 1))));
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    return pairs;
  }

  void add_stitch(std::int32_t s, const SeamDirection& direction) {
    const PatternStitch& stitch = pattern_.stitches[s];
    GarmentMesh::Stitch& out = mesh_.stitches.emplace_back();
    out.direction = direction;
    out.a = vertices_of(stitch.a);
    out.b = vertices_of(stitch.b);
    out.closure = stitch.closure;
    if (stitch.closure == PatternStitch::Closure::buttons) out.buttons = buttons_of(stitch, out);
    if (!direction.start_to_start) std::reverse(out.b.begin(), out.b.end());
    out.length_a = edge_length(pattern_.panels[stitch.a.panel], stitch.a.edge);
    out.length_b = edge_length(pattern_.panels[stitch.b.panel], stitch.b.edge);
    out.name = fmt::format("stitch {}: {} to {}", s, detail::edge_name(pattern_, stitch.a),
                           detail::edge_name(pattern_, stitch.b));
    if (direction.twisted)
      mesh_.notes.push_back(out.name + ": the seam is twisted as the panels stand");
  }

  void collect_labels() {
    for (std::int32_t p = 0; p < count_of(pattern_.panels); ++p) {
      const PatternPanel& panel = pattern_.panels[p];
      mesh_.panel_labels.push_back(panel.label);
      for (std::int32_t e = 0; e < count_of(panel.edges); ++e) {
        if (panel.edges[e].label.empty()) continue;
        std::vector<std::int32_t>& list = mesh_.labels[panel.edges[e].label];
        const auto& vertices = mesh_.edge_vertices[p][e];
        list.insert(list.end(), vertices.begin(), vertices.end());
      }
    }
    for (auto& [label, list] : mesh_.labels) {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
    }
  }

  void collect_lines(std::int32_t p) {
    const PatternPanel& panel = pattern_.panels[p];
    mesh_.panel_fabrics.push_back(panel.fabric);
    const auto add_elastic = [&](std::int32_t edge, const PatternElastic& elastic) {
      const PatternStitch::Side side{p, edge};
      if (elastic.ratio > 0.0 && vertices_of(side).size() > 1)
        mesh_.elastics.push_back({vertices_of(side), elastic, detail::edge_name(pattern_, side)});
    };
    const std::int32_t edges = count_of(panel.edges);
    for (std::int32_t e = 0; e < edges; ++e) add_elastic(e, panel.edges[e].elastic);
    for (std::int32_t l = 0; l < count_of(panel.lines); ++l) {
      const PatternLine& line = panel.lines[l];
      add_elastic(edges + l, line.elastic);
      if (line.angle)
        mesh_.folds.push_back({mesh_.line_vertices[p][l], *line.angle, line.stiffness});
    }
  }

  PanelMeshQuality total_quality() const {
    PanelMeshQuality all;
    all.least_angle = all.least_free_angle = std::numbers::pi;
    double edges = 0.0;
    for (const PanelMeshQuality& q : mesh_.panel_quality) {
      all.shortest = all.vertices == 0 ? q.shortest : std::min(all.shortest, q.shortest);
      all.longest = std::max(all.longest, q.longest);
      all.least_angle = std::min(all.least_angle, q.least_angle);
      all.least_free_angle = std::min(all.least_free_angle, q.least_free_angle);
      all.area += q.area;
      all.vertices += q.vertices;
      all.triangles += q.triangles;
      // Euler's formula for a disc: edges = vertices + triangles - 1.
      const auto of_panel = static_cast<double>(q.vertices + q.triangles - 1);
      edges += of_panel;
      all.mean += of_panel * q.mean;
      all.mean_least_angle += static_cast<double>(q.triangles) * q.mean_least_angle;
    }
    all.mean /= edges;
    all.mean_least_angle /= static_cast<double>(all.triangles);
    return all;
  }

  const SewingPattern& pattern_;
  const PanelMeshConfig& config_;
  const detail::ShortEdges& short_edges_;
  GarmentMesh mesh_;
  std::vector<detail::MeshedPanel> meshed_;
  double middle_;  // m, x of the plane in which panels may be mirror images
  double next_x_ = 0.0;
};

}  // namespace

GarmentMesh mesh_garment(const SewingPattern& pattern, const PanelMeshConfig& config) {
  require(config.edge_length > 0.0 && std::isfinite(config.edge_length), "edge_length",
          config.edge_length, "positive and finite");
  require(config.gap >= 0.0 && std::isfinite(config.gap), "gap", config.gap, "at least 0");
  require(config.vertices > 0 && config.vertices <= 100000000, "vertices",
          static_cast<double>(config.vertices), "from 1 to 100000000");
  check_sewing_pattern(pattern, config.limits);
  const detail::ShortEdges joined(pattern, config.edge_length), whole(pattern);
  if (!joined.any()) return GarmentMesher(pattern, config, whole).run();
  try {
    return GarmentMesher(pattern, config, joined).run();
  } catch (const std::invalid_argument&) {  // a panel so narrow that its joined border meets itself
    return GarmentMesher(pattern, config, whole).run();
  }
}

}  // namespace selvedge
