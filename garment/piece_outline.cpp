// SPDX-License-Identifier: MIT
//
// Outlines of drawn pieces: lines joined to loops, loops divided into edges.
#include <fmt/format.h>
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/garment/detail/pattern_names.h>
#include <selvedge/garment/detail/piece_outline.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

namespace selvedge::detail {
namespace {

constexpr double kCornerAngle = 25.0 * std::numbers::pi / 180.0;  // from which a turn ends an edge
constexpr double kSamePoint = 1e-5;                               // m
constexpr double kLargestGap = 0.003;                             // m, that is closed in an outline
constexpr double kNearLine = 0.004;                               // m, of marks from the outline

double cross_of(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

double signed_area(const std::vector<Vec2>& loop) {
  double twice = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    twice += cross_of(loop[i] - loop[0], loop[(i + 1) % loop.size()] - loop[0]);
  return 0.5 * twice;
}

/// Angle by which a loop turns at a point, rad.
double turn_at(const std::vector<Vec2>& loop, std::size_t i) {
  const std::size_t n = loop.size();
  const Vec2 u = loop[i] - loop[(i + n - 1) % n], v = loop[(i + 1) % n] - loop[i];
  return elementary::atan2(cross_of(u, v), u.dot(v));
}

/// The point of a loop nearest to p: its side, the share of it, and the distance.
struct OnLoop {
  std::size_t side = 0;
  double share = 0.0, distance = 1e300;
};
OnLoop nearest_on(const std::vector<Vec2>& loop, const Vec2& p) {
  OnLoop best;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2 &a = loop[i], d = loop[(i + 1) % loop.size()] - a;
    const double share =
        d.squaredNorm() > 0.0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0.0;
    const double distance = (a + share * d - p).norm();
    if (distance < best.distance) best = {i, share, distance};
  }
  return best;
}

/// The points of a loop at which its edges end.
std::vector<char> corners_of(const std::vector<Vec2>& loop, const std::vector<Vec2>& turns) {
  std::vector<char> is_corner(loop.size(), 0);
  for (const Vec2& p : turns)
    for (std::size_t i = 0; i < loop.size(); ++i)
      if ((loop[i] - p).norm() < kNearLine / 4.0) is_corner[i] = 1;
  auto count = std::count(is_corner.begin(), is_corner.end(), 1);
  if (count < 3)
    for (std::size_t i = 0; i < loop.size(); ++i)
      if (std::abs(turn_at(loop, i)) > kCornerAngle) is_corner[i] = 1;
  // A line without corners ends somewhere all the same.
  count = std::count(is_corner.begin(), is_corner.end(), 1);
  for (std::size_t k = 0; count < 2 && k < 2; ++k) {
    std::size_t first = 0;
    while (first < loop.size() && !is_corner[first]) ++first;
    if (first == loop.size()) first = 0;
    is_corner[first] = is_corner[(first + loop.size() / 2) % loop.size()] = 1;
    count = std::count(is_corner.begin(), is_corner.end(), 1);
  }
  return is_corner;
}

bool is_straight(const Vec2& a, const Vec2& b, const std::vector<Vec2>& through) {
  return std::all_of(through.begin(), through.end(), [&](const Vec2& p) {
    return std::abs(cross_of(b - a, p - a)) <= kSamePoint * (b - a).norm();
  });
}

/// A loop as a panel, and for each of its sides the edge to which it belongs.
struct OutlinePanel {
  PatternPanel panel;
  std::vector<Vec2> loop;             // m, the first point is a corner
  std::vector<std::int32_t> edge_of;  // per side
  std::vector<std::size_t> first;     // per edge: its first side
};

OutlinePanel panel_of_loop(std::vector<Vec2> loop, const std::vector<Vec2>& turns) {
  if (signed_area(loop) < 0.0) std::reverse(loop.begin(), loop.end());
  std::vector<char> is_corner = corners_of(loop, turns);
  const auto start = std::find(is_corner.begin(), is_corner.end(), 1) - is_corner.begin();
  std::rotate(loop.begin(), loop.begin() + start, loop.end());
  std::rotate(is_corner.begin(), is_corner.begin() + start, is_corner.end());
  OutlinePanel made;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    if (is_corner[i]) {
      made.panel.vertices.push_back(loop[i]);
      made.panel.edges.emplace_back();
      made.first.push_back(i);
    } else {
      made.panel.edges.back().curve.through.push_back(loop[i]);
    }
    made.edge_of.push_back(static_cast<std::int32_t>(made.panel.edges.size()) - 1);
  }
  const auto n = static_cast<std::int32_t>(made.panel.edges.size());
  for (std::int32_t e = 0; e < n; ++e) {
    PatternEdge& edge = made.panel.edges[e];
    edge.endpoints = {e, (e + 1) % n};
    const bool straight =
        is_straight(made.panel.vertices[e], made.panel.vertices[(e + 1) % n], edge.curve.through);
    if (straight) edge.curve.through.clear();
    edge.curve.kind = straight ? PatternCurve::Kind::straight : PatternCurve::Kind::polyline;
  }
  made.loop = std::move(loop);
  return made;
}

/// Share of the length of its edge at which a place of a loop lies.
double share_on_edge(const OutlinePanel& made, const OnLoop& place) {
  const std::int32_t edge = made.edge_of[place.side];
  double before = 0.0, all = 0.0;
  for (std::size_t i = made.first[edge]; i < made.loop.size() && made.edge_of[i] == edge; ++i) {
    const double side = (made.loop[(i + 1) % made.loop.size()] - made.loop[i]).norm();
    if (i < place.side) before += side;
    if (i == place.side) before += place.share * side;
    all += side;
  }
  return all > 0.0 ? before / all : 0.0;
}

std::string lower(std::string_view text) {
  std::string out;
  for (const char c : text) out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

Vec2 bounds_of(const std::vector<Vec2>& loop) {
  Vec2 low = loop.front(), high = low;
  for (const Vec2& p : loop) low = low.cwiseMin(p), high = high.cwiseMax(p);
  return high - low;
}

}  // namespace

PieceLayer piece_layer(std::string_view name) {
  const std::string text = lower(name);
  const auto digit = text.find_first_of("0123456789");
  if (digit != std::string::npos && (digit == 0 || text.starts_with("layer"))) {
    int number = 0;
    std::from_chars(text.data() + digit, text.data() + text.size(), number);
    if (number >= 80 && number <= 83) return PieceLayer::notch;
    for (const PieceLayer layer :
         {PieceLayer::boundary, PieceLayer::turn, PieceLayer::curve, PieceLayer::notch,
          PieceLayer::grade, PieceLayer::mirror, PieceLayer::grain, PieceLayer::internal,
          PieceLayer::cutout, PieceLayer::drill, PieceLayer::sew, PieceLayer::annotation})
      if (static_cast<int>(layer) == number) return layer;
    return PieceLayer::other;
  }
  const std::pair<const char*, PieceLayer> words[] = {
      {"cutout", PieceLayer::cutout},     {"turn", PieceLayer::turn},
      {"curve", PieceLayer::curve},       {"notch", PieceLayer::notch},
      {"grade", PieceLayer::grade},       {"mirror", PieceLayer::mirror},
      {"fold", PieceLayer::mirror},       {"grain", PieceLayer::grain},
      {"internal", PieceLayer::internal}, {"drill", PieceLayer::drill},
      {"sew", PieceLayer::sew},           {"seam", PieceLayer::sew},
      {"stitch", PieceLayer::sew},        {"annot", PieceLayer::annotation},
      {"text", PieceLayer::annotation},   {"boundary", PieceLayer::boundary},
      {"cut", PieceLayer::boundary},      {"outline", PieceLayer::boundary}};
  for (const auto& [word, layer] : words)
    if (text.find(word) != std::string::npos) return layer;
  return PieceLayer::other;
}

double piece_extent(const PieceDrawing& drawing) {
  double most = 0.0;
  std::vector<Vec2> all;
  for (const PieceLine& line : drawing.lines)
    all.insert(all.end(), line.points.begin(), line.points.end());
  if (!all.empty()) most = bounds_of(all).maxCoeff();
  return most;
}

std::vector<std::vector<Vec2>> closed_loops(const PieceDrawing& drawing, PieceLayer layer,
                                            double gap, const std::string& file,
                                            std::vector<std::string>& notes) {
  std::vector<std::vector<Vec2>> loops, open;
  for (const PieceLine& line : drawing.lines) {
    if (line.layer != layer || line.points.size() < 2) continue;
    std::vector<Vec2> points = line.points;
    const bool meets = (points.front() - points.back()).norm() < 1e-9 + 1e-3 * gap;
    if ((line.is_closed || meets) && points.size() > 2) {
      if (meets) points.pop_back();
      loops.push_back(std::move(points));
    } else {
      open.push_back(std::move(points));
    }
  }
  while (!open.empty()) {
    std::vector<Vec2> chain = std::move(open.back());
    open.pop_back();
    double widest = 0.0;
    while (true) {
      // The line that begins or ends nearest to the end of the chain, or its own start.
      double least = chain.size() > 2 ? (chain.front() - chain.back()).norm() : 1e300;
      std::ptrdiff_t best = -1;
      for (std::size_t i = 0; i < open.size(); ++i)
        for (const Vec2& end : {open[i].front(), open[i].back()})
          if ((end - chain.back()).norm() < least) {
            least = (end - chain.back()).norm();
            best = static_cast<std::ptrdiff_t>(i);
          }
      if (least > gap)
        throw std::invalid_argument(
            fmt::format("{}: piece {}: its outline is open at ({:g}, {:g}), {:g} units from where "
                        "it could go on; "
                        "close the outline",
                        file, quoted(drawing.name), chain.back().x(), chain.back().y(),
                        least > 1e299 ? 0.0 : least));
      widest = std::max(widest, least);
      if (best < 0) break;
      std::vector<Vec2> next = std::move(open[static_cast<std::size_t>(best)]);
      open.erase(open.begin() + best);
      if ((next.back() - chain.back()).norm() < (next.front() - chain.back()).norm())
        std::reverse(next.begin(), next.end());
      chain.insert(chain.end(), next.begin() + (least < 1e-6 * gap ? 1 : 0), next.end());
    }
    if ((chain.front() - chain.back()).norm() <= gap) chain.pop_back();
    if (widest > 0.02 * gap)
      notes.push_back(
          fmt::format("piece {}: its outline is open by up to {:.3g} units, which are closed",
                      quoted(drawing.name), widest));
    if (chain.size() > 2) loops.push_back(std::move(chain));
  }
  std::stable_sort(loops.begin(), loops.end(), [](const auto& a, const auto& b) {
    return std::abs(signed_area(a)) > std::abs(signed_area(b));
  });
  return loops;
}

void add_piece(const PieceDrawing& drawing, double unit, PatternImport& import,
               std::vector<SeamMark>& marks) {
  const std::string& file = import.drawn.name;
  const std::string piece = "piece " + quoted(drawing.name);
  auto loops = closed_loops(drawing, PieceLayer::sew, kLargestGap / unit, file, import.notes);
  const bool is_sewn = !loops.empty();
  if (!is_sewn)
    loops = closed_loops(drawing, PieceLayer::boundary, kLargestGap / unit, file, import.notes);
  if (loops.empty()) {
    std::string kinds;
    for (const std::string& kind : drawing.left_out) kinds += (kinds.empty() ? "" : ", ") + kind;
    throw std::invalid_argument(
        fmt::format("{}: {} has no closed outline on layer 1 or 14{}; export it as POLYLINE", file,
                    piece, kinds.empty() ? "" : ", but " + kinds + ", which cannot be read"));
  }
  import.notes.push_back(
      fmt::format("{}: {} taken for its outline", piece,
                  is_sewn ? "the sew line (layer 14)" : "the boundary (layer 1)"));
  if (loops.size() > 1)
    import.notes.push_back(
        fmt::format("{}: {} smaller closed lines inside are not cut out", piece, loops.size() - 1));
  std::vector<Vec2> loop, turns;
  for (const Vec2& p : loops.front())
    if (loop.empty() || (unit * p - loop.back()).norm() > kSamePoint) loop.push_back(unit * p);
  while (loop.size() > 1 && (loop.front() - loop.back()).norm() <= kSamePoint) loop.pop_back();
  if (loop.size() < 3)
    throw std::invalid_argument(
        fmt::format("{}: {}: its outline has no area; give at least three points", file, piece));
  for (const Vec2& p : drawing.turns) turns.push_back(unit * p);
  for (const PieceLine& line : drawing.lines)  // the ends of a fold are corners
    if (line.layer == PieceLayer::mirror)
      for (const Vec2& p : {line.points.front(), line.points.back()})
        if (!turns.empty()) turns.push_back(unit * p);
  OutlinePanel made = panel_of_loop(std::move(loop), turns);
  DrawnPanel panel;
  panel.panel = std::move(made.panel);
  panel.panel.name = drawing.name;
  const auto n = static_cast<std::int32_t>(panel.panel.edges.size());
  for (const PieceLine& line : drawing.lines) {
    if (line.points.size() < 2) continue;
    const Vec2 a = unit * line.points.front(), b = unit * line.points.back();
    if (line.layer == PieceLayer::grain && (b - a).norm() > 0.0) {
      const Vec2 g = (b - a).normalized();
      panel.grain = g.y() < -1e-9 || (std::abs(g.y()) <= 1e-9 && g.x() < 0.0) ? Vec2(-g) : g;
    }
    if (line.layer == PieceLayer::notch) {
      const OnLoop at = nearest_on(made.loop, a), other = nearest_on(made.loop, b);
      const OnLoop& place = at.distance <= other.distance ? at : other;
      if (place.distance < kNearLine)
        panel.notches.push_back({made.edge_of[place.side], share_on_edge(made, place), ""});
    }
    if (line.layer != PieceLayer::mirror) continue;
    for (std::int32_t e = 0; e < n; ++e) {
      const Vec2 &p = panel.panel.vertices[e], &q = panel.panel.vertices[(e + 1) % n];
      if (std::min((p - a).norm() + (q - b).norm(), (p - b).norm() + (q - a).norm()) < kNearLine)
        panel.fold = e;
    }
    if (panel.fold < 0)
      import.notes.push_back(
          fmt::format("{}: its mirror line is no edge, so it is not opened", piece));
  }
  for (const Vec2& p : drawing.notches) {
    const OnLoop place = nearest_on(made.loop, unit * p);
    if (place.distance < kNearLine)
      panel.notches.push_back({made.edge_of[place.side], share_on_edge(made, place), ""});
  }
  panel.is_pair = drawing.quantity == 2 && panel.fold < 0;
  for (const PieceText& text : drawing.texts) {
    const std::string words = lower(text.words);
    if (!words.starts_with("seam ")) continue;
    SeamMark mark;
    const auto [end, fault] =
        std::from_chars(words.data() + 5, words.data() + words.size(), mark.number);
    if (fault != std::errc() || end == words.data() + 5) continue;
    mark.panel = static_cast<std::int32_t>(import.drawn.panels.size());
    mark.edge = made.edge_of[nearest_on(made.loop, unit * text.at).side];
    marks.push_back(mark);
  }
  import.drawn.panels.push_back(std::move(panel));
}

void join_marks(const std::vector<SeamMark>& marks, PatternImport& import) {
  std::map<int, std::vector<SeamMark>> seams;
  for (const SeamMark& mark : marks) seams[mark.number].push_back(mark);
  for (const auto& [number, ends] : seams) {
    if (ends.size() != 2) {
      import.notes.push_back(fmt::format(
          "\"Seam {}\" stands at {} edges, not two, so it is left out", number, ends.size()));
      continue;
    }
    import.drawn.stitches.push_back({{{ ends[0].panel,
                                        {ends[0].edge},
                                        false }},
                                     {{ ends[1].panel,
                                        {ends[1].edge},
                                        false }},
                                     false});
  }
}

}  // namespace selvedge::detail
