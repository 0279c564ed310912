// SPDX-License-Identifier: MIT
//
// Short edges: patterns that programs write have edges far shorter than the triangles of a mesh,
// left by trimming and by curves made of many chords. Triangles that small cost time steps and
// show nothing, so runs of such edges become single vertices.
#include <fmt/format.h>
#include <selvedge/garment/detail/pattern_names.h>
#include <selvedge/garment/detail/short_edges.h>

#include <algorithm>
#include <array>
#include <map>

namespace selvedge::detail {
namespace {

constexpr double kLongestRun = 0.2;      // of the edge length of the mesh
constexpr std::int32_t kLeastEdges = 3;  // that a panel keeps
constexpr std::size_t kMostNamed = 4;    // edges that a note names

using Side = PatternStitch::Side;

}  // namespace

ShortEdges::ShortEdges(const SewingPattern& pattern) : pattern_(pattern) {
  for (const PatternPanel& panel : pattern.panels) {
    std::vector<double>& lengths = length_.emplace_back();
    for (std::size_t e = 0; e < panel.edges.size(); ++e)
      lengths.push_back(edge_length(panel, static_cast<std::int32_t>(e)));
    joined_.emplace_back(panel.edges.size(), 0);
    kept_.push_back(static_cast<std::int32_t>(panel.edges.size()));
  }
}

ShortEdges::ShortEdges(const SewingPattern& pattern, double edge_length) : ShortEdges(pattern) {
  longest_ = kLongestRun * edge_length;
  std::map<std::array<std::int32_t, 2>, Side> partner;
  for (const PatternStitch& s : pattern.stitches) {
    partner[{s.a.panel, s.a.edge}] = s.b;
    partner[{s.b.panel, s.b.edge}] = s.a;
  }
  struct Candidate {
    double length;
    std::int32_t panel, edge;
    auto operator<=>(const Candidate&) const = default;
  };
  std::vector<Candidate> candidates;
  for (std::size_t p = 0; p < length_.size(); ++p)
    for (std::size_t e = 0; e < length_[p].size(); ++e)
      if (length_[p][e] < longest_)
        candidates.push_back(
            {length_[p][e], static_cast<std::int32_t>(p), static_cast<std::int32_t>(e)});
  std::sort(candidates.begin(), candidates.end());
  const auto join = [&](std::int32_t panel, std::int32_t edge, bool is_joined) {
    joined_[panel][edge] = static_cast<char>(is_joined);
    kept_[panel] += is_joined ? -1 : 1;
  };
  for (const auto& [length, panel, edge] : candidates) {
    if (is_joined(panel, edge) || !can_join(panel, edge)) continue;
    join(panel, edge, true);
    const auto found = partner.find({panel, edge});
    if (found == partner.end()) continue;
    const Side& other = found->second;
    if (can_join(other.panel, other.edge))
      join(other.panel, other.edge, true);
    else
      join(panel, edge, false);
  }
}

bool ShortEdges::any() const {
  return std::any_of(joined_.begin(), joined_.end(), [](const std::vector<char>& of_panel) {
    return std::find(of_panel.begin(), of_panel.end(), 1) != of_panel.end();
  });
}

std::int32_t ShortEdges::around(std::int32_t panel, std::int32_t edge) const {
  const auto n = static_cast<std::int32_t>(joined_[panel].size());
  return (edge + n) % n;
}

/// Length of the run of joined edges that begins beside an edge, m.
double ShortEdges::run_length(std::int32_t panel, std::int32_t edge, std::int32_t step) const {
  double length = 0.0;
  for (std::int32_t e = around(panel, edge + step); e != edge && is_joined(panel, e);
       e = around(panel, e + step))
    length += length_[panel][e];
  return length;
}

bool ShortEdges::can_join(std::int32_t panel, std::int32_t edge) const {
  return kept_[panel] > kLeastEdges &&
         run_length(panel, edge, -1) + length_[panel][edge] + run_length(panel, edge, 1) < longest_;
}

/// Where the mesh has the start of an edge: at its vertex, or in the middle of its run.
Vec2 ShortEdges::corner(std::int32_t panel, std::int32_t edge) const {
  const PatternPanel& shape = pattern_.panels[panel];
  std::int32_t first = edge, end = edge;  // the edges of the run, `end` not included
  while (is_joined(panel, around(panel, first - 1))) first = around(panel, first - 1);
  while (is_joined(panel, end)) end = around(panel, end + 1);
  if (first == end) return shape.vertices[shape.edges[edge].endpoints[0]];
  double half = 0.0;
  for (std::int32_t e = first; e != end; e = around(panel, e + 1)) half += 0.5 * length_[panel][e];
  std::int32_t e = first;
  for (; half > length_[panel][e]; e = around(panel, e + 1)) half -= length_[panel][e];
  return edge_point(shape, e, half / length_[panel][e]);
}

std::vector<Vec2> ShortEdges::divide(std::int32_t panel, std::int32_t edge,
                                     std::int32_t pieces) const {
  std::vector<Vec2> points = divide_edge(pattern_.panels[panel], edge, pieces);
  // Vertices that are not in a run keep their bits.
  const Vec2 first = corner(panel, edge) - points.front(),
             last = corner(panel, around(panel, edge + 1)) - points.back();
  if (first.isZero(0.0) && last.isZero(0.0)) return points;
  for (std::int32_t i = 0; i <= pieces; ++i) {
    const double t = static_cast<double>(i) / pieces;
    points[static_cast<std::size_t>(i)] += (1.0 - t) * first + t * last;
  }
  return points;
}

std::vector<std::string> ShortEdges::notes() const {
  std::vector<std::string> notes;
  for (std::size_t p = 0; p < joined_.size(); ++p) {
    std::string names;
    std::size_t count = 0;
    for (std::size_t e = 0; e < joined_[p].size(); ++e) {
      if (!joined_[p][e]) continue;
      if (++count <= kMostNamed) names += fmt::format("{}{}", count > 1 ? ", " : "", e);
    }
    if (count == 0) continue;
    if (count > kMostNamed) names += fmt::format(" and {} others", count - kMostNamed);
    notes.push_back(fmt::format(
        "panel {}: edge{} {} {} shorter than {:.2g} mm and joined with {} neighbours in the mesh",
        quoted(pattern_.panels[p].name), count > 1 ? "s" : "", names, count > 1 ? "are" : "is",
        1e3 * longest_, count > 1 ? "their" : "its"));
  }
  return notes;
}

}  // namespace selvedge::detail
