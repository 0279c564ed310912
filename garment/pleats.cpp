// SPDX-License-Identifier: MIT
//
// Pleats: an edge a-b gives up its cloth between a and b. It is folded in the middle m behind the
// cloth beside it, and its halves a-m and m-b are sewn to each other along the edge, so that a and
// b meet. Fold lines lead from m and from the side to which it lies.
#include <fmt/format.h>
#include <selvedge/garment/detail/pattern_names.h>
#include <selvedge/garment/internal/drawn_pattern.h>

#include <algorithm>
#include <numbers>
#include <stdexcept>

namespace selvedge {
namespace {

/// By which a pressed pleat is folded, rad; flat layers would lie in one plane.
constexpr double kPressed = 0.95 * std::numbers::pi;
constexpr double kLeastBetween = 1e-3;  // m, of an edge between two pleats and at its ends

class Pleating {
 public:
  Pleating(const DrawnPattern& drawn, std::int32_t panel)
      : drawn_(drawn), number_(panel), old_(drawn.panels[static_cast<std::size_t>(panel)]) {}

  /// The panel with its pleats; `stitches` gets those that close them.
  DrawnPanel run(std::vector<DrawnStitch>& stitches) {
    made_ = old_;
    made_.panel.edges.clear();
    made_.pleats.clear();
    made_.is_taken_up.clear();
    for (std::int32_t e = 0; e < count(old_.panel.edges); ++e) {
      first_.push_back(count(made_.panel.edges));
      divide(e, stitches);
    }
    first_.push_back(count(made_.panel.edges));
    if (old_.fold >= 0) made_.fold = first_[old_.fold];
    for (PatternNotch& notch : made_.notches) move(notch);
    return std::move(made_);
  }

  /// What remains of an edge beside its pleats, in the order of the loop.
  std::vector<std::int32_t> parts_of(std::int32_t edge, const DrawnPanel& made) const {
    std::vector<std::int32_t> parts;
    for (std::int32_t e = first_[edge]; e < first_[edge + 1]; ++e)
      if (!made.is_taken_up[e]) parts.push_back(e);
    return parts;
  }

 private:
  static std::int32_t count(const auto& list) { return static_cast<std::int32_t>(list.size()); }

  [[noreturn]] void refuse(const std::string& fault) const {
    throw std::invalid_argument(
        fmt::format("{}: panel {}: {}", drawn_.name, detail::quoted(old_.panel.name), fault));
  }

  void add_edge(std::int32_t from, std::int32_t to, const PatternCurve& curve,
                const PatternEdge& old, bool is_taken_up) {
    made_.panel.edges.push_back({{from, to}, curve, old.label, old.elastic});
    made_.is_taken_up.push_back(static_cast<char>(is_taken_up));
  }

  void divide(std::int32_t e, std::vector<DrawnStitch>& stitches) {
    const PatternEdge& edge = old_.panel.edges[e];
    const std::vector<DrawnPleat> pleats = pleats_of(e);
    if (pleats.empty())
      return add_edge(edge.endpoints[0], edge.endpoints[1], edge.curve, edge, false);
    const double length = edge_length(old_.panel, e);
    std::vector<double> shares;
    for (const DrawnPleat& pleat : pleats)
      for (const double way : {-pleat.depth, 0.0, pleat.depth})
        shares.push_back(pleat.at + way / length);
    const EdgeParts parts = split_edge(old_.panel, e, shares);
    std::int32_t from = edge.endpoints[0];
    for (std::size_t i = 0; i < parts.curves.size(); ++i) {
      std::int32_t to = edge.endpoints[1];
      if (i < parts.points.size()) {
        to = count(made_.panel.vertices);
        made_.panel.vertices.push_back(parts.points[i]);
      }
      add_edge(from, to, parts.curves[i], edge, i % 3 != 0);
      from = to;
    }
    for (std::int32_t k = 0; k < count(pleats); ++k)
      add_fold(pleats[k], first_[e] + 3 * k + 1, stitches);
  }

  /// The pleats of an edge in their order along it.
  std::vector<DrawnPleat> pleats_of(std::int32_t e) const {
    std::vector<DrawnPleat> pleats;
    for (const DrawnPleat& pleat : old_.pleats) {
      if (pleat.edge < 0 || pleat.edge >= count(old_.panel.edges))
        refuse(fmt::format("a pleat is on edge {}; give one of the edges 0 to {}", pleat.edge,
                           count(old_.panel.edges) - 1));
      if (pleat.edge == e) pleats.push_back(pleat);
    }
    std::stable_sort(pleats.begin(), pleats.end(),
                     [](const DrawnPleat& a, const DrawnPleat& b) { return a.at < b.at; });
    const double length = edge_length(old_.panel, e);
    double end = 0.0;  // m, of the pleat before
    for (const DrawnPleat& pleat : pleats) {
      if (!(pleat.depth > 0.0) || !(pleat.length > 0.0))
        refuse(fmt::format("a pleat of edge {} is {:g} m deep and {:g} m long; give both above 0",
                           e, pleat.depth, pleat.length));
      if (!(pleat.at * length - pleat.depth > end + kLeastBetween))
        refuse(
            fmt::format("the pleat at {:g} of edge {} begins before the end of another one or "
                        "of the edge; move it or make it less deep",
                        pleat.at, e));
      end = pleat.at * length + pleat.depth;
    }
    if (!pleats.empty() && end > length - kLeastBetween)
      refuse(
          fmt::format("the pleat at {:g} of edge {} leads beyond the end of the edge; move it or "
                      "make it less deep",
                      pleats.back().at, e));
    return pleats;
  }

  /// The fold lines of a pleat whose halves are the edges `half` and `half` + 1, and its stitch.
  void add_fold(const DrawnPleat& pleat, std::int32_t half, std::vector<DrawnStitch>& stitches) {
    PatternPanel& panel = made_.panel;
    const std::int32_t a = panel.edges[half].endpoints[0], m = panel.edges[half].endpoints[1],
                       b = panel.edges[half + 1].endpoints[1];
    const Vec2 along = (panel.vertices[b] - panel.vertices[a]).normalized();
    const double side = panel_area(old_.panel) > 0.0 ? 1.0 : -1.0;
    const Vec2 inward = side * Vec2(-along.y(), along.x());
    const auto add_line = [&](std::int32_t from, double angle) {
      panel.vertices.push_back(panel.vertices[from] + pleat.length * inward);
      panel.lines.push_back({.endpoints = {from, count(panel.vertices) - 1}, .angle = angle});
    };
    add_line(pleat.to_end ? b : a, kPressed);
    add_line(m, -kPressed);
    stitches.push_back({{{number_, {half}, false}}, {{number_, {half + 1}, false}}, false});
  }

  /// A notch stays where it is on its edge.
  void move(PatternNotch& notch) const {
    if (notch.edge < 0 || notch.edge + 1 >= count(first_)) return;  // refused later
    double left = notch.at * edge_length(old_.panel, notch.edge);
    std::int32_t e = first_[notch.edge];
    for (; e + 1 < first_[notch.edge + 1]; ++e) {
      const double length = edge_length(made_.panel, e);
      if (left <= length) break;
      left -= length;
    }
    notch.edge = e;
    notch.at = std::clamp(left / edge_length(made_.panel, e), 0.0, 1.0);
  }

  const DrawnPattern& drawn_;
  std::int32_t number_;
  const DrawnPanel& old_;
  DrawnPanel made_;
  std::vector<std::int32_t> first_;  // per old edge: its first part, and the end of all
};

}  // namespace

DrawnPattern with_pleats(DrawnPattern drawn) {
  const DrawnPattern old = drawn;
  for (std::size_t p = 0; p < old.panels.size(); ++p) {
    if (old.panels[p].pleats.empty()) continue;
    const auto number = static_cast<std::int32_t>(p);
    Pleating pleating(old, number);
    std::vector<DrawnStitch> closing;
    drawn.panels[p] = pleating.run(closing);
    const auto edges = static_cast<std::int32_t>(old.panels[p].panel.edges.size());
    const auto more = static_cast<std::int32_t>(drawn.panels[p].panel.edges.size()) - edges;
    for (DrawnStitch& stitch : drawn.stitches)
      for (DrawnChain* chain : {&stitch.a, &stitch.b})
        for (DrawnLink& link : *chain) {
          if (link.panel != number) continue;
          std::vector<std::int32_t> parts;
          for (const std::int32_t e : link.edges) {
            if (e < 0 || e >= edges) {
              parts.push_back(e < 0 ? e : e + more);  // a line
              continue;
            }
            const std::vector<std::int32_t> own = pleating.parts_of(e, drawn.panels[p]);
            parts.insert(parts.end(), own.begin(), own.end());
          }
          link.edges = std::move(parts);
        }
    drawn.stitches.insert(drawn.stitches.end(), closing.begin(), closing.end());
  }
  return drawn;
}

}  // namespace selvedge
