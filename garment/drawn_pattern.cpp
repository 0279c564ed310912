// SPDX-License-Identifier: MIT
//
// Pieces as people draw them, made into panels whose edges are sewn one to one.
#include <fmt/format.h>
#include <selvedge/garment/detail/pattern_names.h>
#include <selvedge/garment/internal/drawn_pattern.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

namespace selvedge {
namespace {

using Corner = std::pair<std::int32_t, std::int32_t>;  // panel, edge
constexpr double kSameEnd = 0.003;                     // m, between ends that meet
constexpr double kLeastPart = 1e-4;                    // m, of a divided edge

std::int32_t edges_of(const PatternPanel& panel) {
  return static_cast<std::int32_t>(panel.edges.size());
}

/// A reflection of the plane: p -> at + m (p - at).
struct Mirror {
  Vec2 at = Vec2::Zero();
  Eigen::Matrix2d m;
  Vec2 of(const Vec2& p) const { return at + m * (p - at); }
};

Mirror mirror_across(const Vec2& a, const Vec2& b) {
  const Vec2 d = (b - a).normalized();
  return {a, 2.0 * d * d.transpose() - Eigen::Matrix2d::Identity()};
}

/// The mirror image of a curve, run through from its end to its start.
PatternCurve mirrored(PatternCurve curve, const Mirror& mirror) {
  for (Vec2& p : curve.control) p = mirror.of(p);
  for (Vec2& p : curve.through) p = mirror.of(p);
  if (curve.kind == PatternCurve::Kind::cubic) std::swap(curve.control[0], curve.control[1]);
  std::reverse(curve.through.begin(), curve.through.end());
  return curve;  // an arc turns the same way: reflection and direction both change it
}

class Sewer {
 public:
  explicit Sewer(const DrawnPattern& drawn) : drawn_(drawn) { sewn_.name = drawn.name; }

  SewingPattern run() {
    for (const DrawnPanel& panel : drawn_.panels) add_panel(panel);
    for (std::size_t s = 0; s < drawn_.stitches.size(); ++s) add_stitch(s);
    cut();
    return std::move(sewn_);
  }

 private:
  [[noreturn]] void refuse(const std::string& fault) const {
    throw std::invalid_argument(fmt::format("{}: {}", drawn_.name, fault));
  }

  struct Notch {
    double at;  // share of its edge
    std::string name;
  };

  // Panels.

  void add_panel(const DrawnPanel& drawn) {
    PatternPanel panel = drawn.panel;
    turn_grain(panel, drawn.grain);
    const auto n = edges_of(panel);
    std::vector<Corner>&own = own_.emplace_back(n, Corner{-1, -1}),
    &other = other_.emplace_back(n, Corner{-1, -1});
    const auto lines = static_cast<std::int32_t>(panel.lines.size());
    std::vector<Corner>&own_line = own_line_.emplace_back(),
    &other_line = other_line_.emplace_back(lines, Corner{-1, -1});
    const auto first = static_cast<std::int32_t>(sewn_.panels.size());
    for (std::int32_t l = 0; l < lines; ++l) own_line.push_back({first, l});
    if (drawn.fold >= 0) {
      open_fold(panel, drawn.fold, own, other);
      mirror_lines(panel, drawn.panel, drawn.fold, other_line);
      sewn_.panels.push_back(std::move(panel));
    } else {
      for (std::int32_t e = 0; e < n; ++e) own[e] = {first, e};
      if (drawn.is_pair) {
        PatternPanel twin = twin_of(panel);
        twin.name += drawn.is_right ? ".left" : ".right";
        for (std::int32_t e = 0; e < n; ++e) other[e] = {first + 1, n - 1 - e};
        for (std::int32_t l = 0; l < lines; ++l) other_line[l] = {first + 1, l};
        panel.name += drawn.is_right ? ".right" : ".left";
        sewn_.panels.push_back(std::move(panel));
        sewn_.panels.push_back(std::move(twin));
      } else {
        sewn_.panels.push_back(std::move(panel));
      }
    }
    for (std::int32_t e = 0; e < n && !drawn.is_taken_up.empty(); ++e)
      if (drawn.is_taken_up[e]) taken_up_.insert({own[e], other[e]});
    for (const PatternNotch& notch : drawn.notches) {
      if (notch.edge < 0 || notch.edge >= n || !(notch.at >= 0.0 && notch.at <= 1.0))
        refuse(
            fmt::format("panel {}: a notch is at {:g} of edge {}; give an edge of the panel and a "
                        "share from 0 to 1",
                        detail::quoted(drawn.panel.name), notch.at, notch.edge));
      if (own[notch.edge].first >= 0) notches_[own[notch.edge]].push_back({notch.at, notch.name});
      if (other[notch.edge].first >= 0)
        notches_[other[notch.edge]].push_back({1.0 - notch.at, notch.name});
    }
  }

  /// The warp runs along y of a panel.
  static void turn_grain(PatternPanel& panel, const Vec2& grain) {
    const Vec2 g = grain.normalized();
    if (g.x() == 0.0 && g.y() > 0.0) return;
    Eigen::Matrix2d turn;
    turn << g.y(), -g.x(), g.x(), g.y();
    const auto apply = [&](Vec2& p) { p = turn * p; };
    for (Vec2& v : panel.vertices) apply(v);
    for (PatternEdge& edge : panel.edges) {
      for (Vec2& p : edge.curve.control) apply(p);
      for (Vec2& p : edge.curve.through) apply(p);
    }
    Mat3 back = Mat3::Identity();
    back.topLeftCorner<2, 2>() = turn.transpose();
    panel.rotation = panel.rotation * back;
  }

  void open_fold(PatternPanel& panel, std::int32_t fold, std::vector<Corner>& own,
                 std::vector<Corner>& other) const {
    const auto n = edges_of(panel);
    if (fold >= n || panel.edges[fold].curve.kind != PatternCurve::Kind::straight)
      refuse(fmt::format("panel {}: its fold must be one of its straight edges, not edge {}",
                         detail::quoted(panel.name), fold));
    const auto p = static_cast<std::int32_t>(sewn_.panels.size());
    const auto [a, b] = panel.edges[fold].endpoints;
    const Mirror mirror = mirror_across(panel.vertices[a], panel.vertices[b]);
    PatternPanel whole = panel;
    whole.edges.clear();
    for (std::int32_t k = 1; k < n; ++k) {
      const std::int32_t e = (fold + k) % n;
      own[e] = {p, k - 1};
      whole.edges.push_back(panel.edges[e]);
    }
    // The ends of the fold belong to both halves.
    std::vector<std::int32_t> image(panel.vertices.size());
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(panel.vertices.size()); ++v) {
      image[v] = v;
      if (v == a || v == b) continue;
      image[v] = static_cast<std::int32_t>(whole.vertices.size());
      whole.vertices.push_back(mirror.of(panel.vertices[v]));
    }
    for (std::int32_t k = n - 1; k >= 1; --k) {
      const std::int32_t e = (fold + k) % n;
      other[e] = {p, edges_of(whole)};
      PatternEdge edge = panel.edges[e];
      edge.endpoints = {image[edge.endpoints[1]], image[edge.endpoints[0]]};
      edge.curve = mirrored(edge.curve, mirror);
      whole.edges.push_back(std::move(edge));
    }
    panel = std::move(whole);
  }

  /// The mirror images of the lines of a piece on a fold, which `whole` is already. A line from
  /// fold to fold is its own image.
  void mirror_lines(PatternPanel& whole, const PatternPanel& half, std::int32_t fold,
                    std::vector<Corner>& other) const {
    const auto [a, b] = half.edges[fold].endpoints;
    const Mirror mirror = mirror_across(whole.vertices[a], whole.vertices[b]);
    const auto image_of = [&](std::int32_t v) {
      if (v == a || v == b) return v;
      const Vec2 wanted = mirror.of(whole.vertices[v]);
      const auto nearest = std::min_element(
          whole.vertices.begin(), whole.vertices.end(), [&](const Vec2& p, const Vec2& q) {
            return (p - wanted).squaredNorm() < (q - wanted).squaredNorm();
          });
      return static_cast<std::int32_t>(nearest - whole.vertices.begin());
    };
    const auto p = static_cast<std::int32_t>(sewn_.panels.size());
    for (std::size_t l = 0; l < half.lines.size(); ++l) {
      PatternLine line = half.lines[l];
      line.endpoints = {image_of(line.endpoints[1]), image_of(line.endpoints[0])};
      if (line.endpoints[0] == half.lines[l].endpoints[1] &&
          line.endpoints[1] == half.lines[l].endpoints[0])
        continue;
      other[l] = {p, static_cast<std::int32_t>(whole.lines.size())};
      whole.lines.push_back(line);
    }
  }

  static PatternPanel twin_of(const PatternPanel& panel) {
    const Mirror mirror = mirror_across(Vec2::Zero(), Vec2(0.0, 1.0));
    PatternPanel twin = panel;
    for (Vec2& v : twin.vertices) v = mirror.of(v);
    std::reverse(twin.edges.begin(), twin.edges.end());
    for (PatternEdge& edge : twin.edges) {
      std::swap(edge.endpoints[0], edge.endpoints[1]);
      edge.curve = mirrored(edge.curve, mirror);
    }
    for (PatternLine& line : twin.lines) std::swap(line.endpoints[0], line.endpoints[1]);
    // The mirror image of the place, with respect to the plane x = 0.
    Mat3 flip = Mat3::Identity();
    flip(0, 0) = -1.0;
    twin.rotation = flip * panel.rotation * flip;
    twin.translation = flip * panel.translation;
    return twin;
  }

  // Stitches.

  struct Chain {
    std::vector<Corner> edges;
    std::vector<double> ends;  // m, length from the start to each end; the first is 0
    std::vector<std::pair<double, std::string>> notches;  // m, by length
    double length() const { return ends.back(); }
  };

  Chain chain_of(const std::vector<Corner>& edges, bool is_reversed) const {
    Chain chain{edges, {0.0}, {}};
    if (is_reversed) std::reverse(chain.edges.begin(), chain.edges.end());
    for (const Corner& c : chain.edges) {
      const double length = edge_length(sewn_.panels[c.first], c.second);
      if (const auto found = notches_.find(c); found != notches_.end())
        for (const Notch& notch : found->second)
          chain.notches.emplace_back(
              chain.ends.back() + length * (is_reversed ? 1.0 - notch.at : notch.at), notch.name);
      chain.ends.push_back(chain.ends.back() + length);
    }
    std::sort(chain.notches.begin(), chain.notches.end());
    return chain;
  }

  /// The next edge along the loop that no pleat takes up.
  Corner after(Corner edge) const {
    const auto n = edges_of(sewn_.panels[edge.first]);
    for (std::int32_t steps = 0; steps < n; ++steps) {
      edge.second = (edge.second + 1) % n;
      if (!taken_up_.contains(edge)) break;
    }
    return edge;
  }

  std::vector<Corner> edges_of_link(const DrawnLink& link, bool is_other,
                                    const std::string& place) const {
    if (link.panel < 0 || link.panel >= static_cast<std::int32_t>(own_.size()))
      refuse(fmt::format("{} names panel {}, which is not there", place, link.panel));
    const DrawnPanel& panel = drawn_.panels[link.panel];
    const std::vector<Corner>& map = is_other ? other_[link.panel] : own_[link.panel];
    std::vector<Corner> edges;
    for (const std::int32_t e : link.edges) {
      if (e < 0 || e >= static_cast<std::int32_t>(map.size()))
        refuse(
            fmt::format("{} names edge {} of panel {}, which has the edges 0 to {}; correct the "
                        "edge",
                        place, e, detail::quoted(panel.panel.name), map.size() - 1));
      if (map[e].first < 0)
        refuse(fmt::format(
            "{} names {}edge {} of panel {}; {}", place, is_other ? "the mirror image of " : "", e,
            detail::quoted(panel.panel.name),
            e == panel.fold ? "the cloth is folded there" : "the panel has no mirror image"));
      edges.push_back(map[e]);
    }
    if (edges.empty()) refuse(place + " has a side without edges");
    // The loop of a mirror image runs the other way.
    if (is_other && edges.size() > 1 && after(edges[0]) != edges[1])
      std::reverse(edges.begin(), edges.end());
    for (std::size_t i = 1; i < edges.size(); ++i)
      if (after(edges[i - 1]) != edges[i])
        refuse(
            fmt::format("{}: the edges of panel {} do not follow each other along its loop; give "
                        "them in order",
                        place, detail::quoted(panel.panel.name)));
    return edges;
  }

  /// The edges of a chain, or those of its mirror image, whose links follow in the other order.
  std::vector<Corner> edges_of_chain(const DrawnChain& chain, bool is_image,
                                     const std::string& place) const {
    std::vector<std::vector<Corner>> links;
    for (const DrawnLink& link : chain)
      links.push_back(edges_of_link(link, link.is_mirrored != is_image, place));
    if (is_image) std::reverse(links.begin(), links.end());
    std::vector<Corner> edges;
    for (const std::vector<Corner>& link : links)
      edges.insert(edges.end(), link.begin(), link.end());
    if (edges.empty()) refuse(place + " has a side without edges");
    return edges;
  }

  void add_stitch(std::size_t s) {
    const DrawnStitch& stitch = drawn_.stitches[s];
    const std::string place = fmt::format("stitch {}", s);
    if (is_line(stitch.a) || is_line(stitch.b)) return add_line_stitch(stitch, place);
    const auto a = edges_of_chain(stitch.a, false, place),
               b = edges_of_chain(stitch.b, false, place);
    join(a, b, stitch, false, place);
    if (!has_image(stitch.a) || !has_image(stitch.b)) return;
    const auto c = edges_of_chain(stitch.a, true, place), d = edges_of_chain(stitch.b, true, place);
    // A seam between a piece and its own image is its own mirror image.
    if (c == b && d == a) return;
    join(c, d, stitch, true, place);
  }

  bool has_image(const DrawnChain& chain) const {
    return std::all_of(chain.begin(), chain.end(), [&](const DrawnLink& link) {
      const DrawnPanel& panel = drawn_.panels[link.panel];
      return panel.fold >= 0 || panel.is_pair;
    });
  }

  // Stitches on lines: of a single edge or line with a single line.

  bool is_line(const DrawnChain& chain) const {
    return std::any_of(chain.begin(), chain.end(), [&](const DrawnLink& link) {
      return std::any_of(link.edges.begin(), link.edges.end(), [&](std::int32_t e) {
        const PatternPanel& panel = drawn_.panels[link.panel].panel;
        return panel.is_line(e) &&
               e < edges_of(panel) + static_cast<std::int32_t>(panel.lines.size());
      });
    });
  }

  /// An edge or line as it is sewn: lines count from -1 down.
  Corner place_of(const DrawnChain& chain, bool is_image, const std::string& place) const {
    if (chain.size() != 1 || chain[0].edges.size() != 1)
      refuse(place + " sews several edges to a line; give a stitch for each line");
    const DrawnLink& link = chain[0];
    const std::int32_t l = link.edges[0] - edges_of(drawn_.panels[link.panel].panel);
    const bool is_other = link.is_mirrored != is_image;
    if (l < 0) return edges_of_link(link, is_other, place)[0];
    const std::vector<Corner>& lines = (is_other ? other_line_ : own_line_)[link.panel];
    if (l >= static_cast<std::int32_t>(lines.size()) || lines[l].first < 0)
      refuse(fmt::format("{} names line {} of panel {}, which is not there", place, l,
                         detail::quoted(drawn_.panels[link.panel].panel.name)));
    return {lines[l].first, -1 - lines[l].second};
  }

  void add_line_stitch(const DrawnStitch& stitch, const std::string& place) {
    const auto direction = stitch.start_to_start ? PatternStitch::Direction::start_to_start
                                                 : PatternStitch::Direction::unknown;
    for (const bool is_image : {false, true}) {
      if (is_image && (!has_image(stitch.a) || !has_image(stitch.b))) continue;
      const Corner a = place_of(stitch.a, is_image, place), b = place_of(stitch.b, is_image, place);
      line_stitches_.push_back({.a = {a.first, a.second},
                                .b = {b.first, b.second},
                                .direction = direction,
                                .closure = stitch.closure,
                                .buttons = buttons_between(stitch, is_image, 0.0, 1.0)});
    }
  }

  /// Buttons of a stitch within a part of its length, as shares of that part.
  static std::vector<double> buttons_between(const DrawnStitch& stitch, bool is_image, double from,
                                             double to) {
    std::vector<double> buttons;
    for (const double share : stitch.buttons) {
      const double at = is_image ? 1.0 - share : share;
      if (at >= from && (at < to || to >= 1.0)) buttons.push_back((at - from) / (to - from));
    }
    std::sort(buttons.begin(), buttons.end());
    return buttons;
  }

  /// A place at which two chains meet, m from the start of each.
  struct Meeting {
    double a, b;
  };

  void join(const std::vector<Corner>& edges_a, const std::vector<Corner>& edges_b,
            const DrawnStitch& stitch, bool is_image, const std::string& place) {
    const bool same_way = stitch.start_to_start;
    const Chain a = chain_of(edges_a, false), b = chain_of(edges_b, !same_way);
    std::vector<Meeting> meetings = matched_notches(a, b, place);
    meetings.insert(meetings.begin(), {0.0, 0.0});
    meetings.push_back({a.length(), b.length()});
    const std::vector<Meeting> map = meetings;
    add_ends(a, b, map, meetings);
    for (std::size_t i = 1; i < meetings.size(); ++i) {
      const double from = meetings[i - 1].a / a.length(),
                   to = i + 1 == meetings.size() ? 1.0 : meetings[i].a / a.length();
      const std::vector<double> buttons = buttons_between(stitch, is_image, from, to);
      if (stitch.closure == PatternStitch::Closure::buttons && buttons.empty()) continue;
      joints_.push_back({cut_between(a, meetings[i - 1].a, meetings[i].a, false),
                         cut_between(b, meetings[i - 1].b, meetings[i].b, !same_way), same_way,
                         stitch.closure, buttons});
    }
  }

  std::vector<Meeting> matched_notches(const Chain& a, const Chain& b,
                                       const std::string& place) const {
    std::vector<Meeting> meetings;
    std::vector<double> plain_a, plain_b;
    for (const auto& [at, name] : a.notches) {
      if (name.empty()) plain_a.push_back(at);
      for (const auto& [other, name_b] : b.notches)
        if (!name.empty() && name == name_b) meetings.push_back({at, other});
    }
    for (const auto& [at, name] : b.notches)
      if (name.empty()) plain_b.push_back(at);
    if (plain_a.size() == plain_b.size())
      for (std::size_t i = 0; i < plain_a.size(); ++i) meetings.push_back({plain_a[i], plain_b[i]});
    std::sort(meetings.begin(), meetings.end(),
              [](const Meeting& p, const Meeting& q) { return p.a < q.a; });
    std::erase_if(meetings, [&](const Meeting& m) {
      return std::min(m.a, m.b) < kSameEnd || m.a > a.length() - kSameEnd ||
             m.b > b.length() - kSameEnd;
    });
    for (std::size_t i = 1; i < meetings.size(); ++i)
      if (!(meetings[i].b > meetings[i - 1].b + kLeastPart) ||
          !(meetings[i].a > meetings[i - 1].a + kLeastPart))
        refuse(place +
               ": its notches follow each other in another order on the other side; correct "
               "their names or the direction of the stitch");
    return meetings;
  }

  /// Adds the ends of the edges within both chains, at equal shares of length between meetings.
  static void add_ends(const Chain& a, const Chain& b, const std::vector<Meeting>& map,
                       std::vector<Meeting>& meetings) {
    const auto across = [&](double at, bool from_a) {
      std::size_t i = 1;
      while (i + 1 < map.size() && (from_a ? map[i].a : map[i].b) < at) ++i;
      const Meeting &p = map[i - 1], &q = map[i];
      const double share = from_a ? (at - p.a) / (q.a - p.a) : (at - p.b) / (q.b - p.b);
      return from_a ? p.b + share * (q.b - p.b) : p.a + share * (q.a - p.a);
    };
    std::vector<char> is_met(b.ends.size(), 0);
    for (std::size_t i = 1; i + 1 < a.ends.size(); ++i) {
      double other = across(a.ends[i], true);
      for (std::size_t j = 1; j + 1 < b.ends.size(); ++j)
        if (!is_met[j] && std::abs(b.ends[j] - other) < kSameEnd) {
          other = b.ends[j];
          is_met[j] = 1;
          break;
        }
      add_meeting({a.ends[i], other}, meetings);
    }
    for (std::size_t j = 1; j + 1 < b.ends.size(); ++j)
      if (!is_met[j]) add_meeting({across(b.ends[j], false), b.ends[j]}, meetings);
  }

  /// A meeting that is hardly apart from another one is that one, moved to the end of an edge.
  static void add_meeting(const Meeting& meeting, std::vector<Meeting>& meetings) {
    const auto next = std::find_if(meetings.begin(), meetings.end(), [&](const Meeting& m) {
      return m.a > meeting.a || m.b > meeting.b;
    });
    for (const auto& near : {next == meetings.begin() ? next : next - 1, next})
      if (near != meetings.end() && std::abs(near->a - meeting.a) < kSameEnd &&
          std::abs(near->b - meeting.b) < kSameEnd)
        return;
    meetings.insert(next, meeting);
  }

  /// A part of an edge, by the share of its middle.
  struct Part {
    Corner edge;
    double middle;
  };

  Part cut_between(const Chain& chain, double from, double to, bool is_reversed) {
    const double middle = 0.5 * (from + to);
    std::size_t i = 0;
    while (i + 2 < chain.ends.size() && chain.ends[i + 1] < middle) ++i;
    const double start = chain.ends[i], length = chain.ends[i + 1] - start;
    const auto share = [&](double at) {
      const double s = (at - start) / length;
      return is_reversed ? 1.0 - s : s;
    };
    const double margin = kLeastPart / length;
    for (const double at : {share(from), share(to)})
      if (at > margin && at < 1.0 - margin) cuts_[chain.edges[i]].push_back(at);
    return {chain.edges[i], share(middle)};
  }

  /// Divides the edges, and makes the stitches.
  void cut() {
    for (auto& [corner, shares] : cuts_) {
      std::sort(shares.begin(), shares.end());
      const double least = kLeastPart / edge_length(sewn_.panels[corner.first], corner.second);
      shares.erase(std::unique(shares.begin(), shares.end(),
                               [&](double s, double t) { return t - s < least; }),
                   shares.end());
    }
    std::vector<std::vector<std::int32_t>> first;  // per panel and edge: its first part
    for (std::int32_t p = 0; p < static_cast<std::int32_t>(sewn_.panels.size()); ++p)
      first.push_back(divide(p));
    const auto side = [&](const Part& part) {
      std::int32_t e = first[part.edge.first][part.edge.second];
      if (const auto found = cuts_.find(part.edge); found != cuts_.end())
        for (const double share : found->second) e += share < part.middle ? 1 : 0;
      return PatternStitch::Side{part.edge.first, e};
    };
    for (const Joint& joint : joints_)
      sewn_.stitches.push_back({side(joint.a), side(joint.b),
                                joint.same_way ? PatternStitch::Direction::start_to_start
                                               : PatternStitch::Direction::end_to_start,
                                joint.closure, joint.buttons});
    for (PatternStitch& stitch : line_stitches_) {
      for (PatternStitch::Side* s : {&stitch.a, &stitch.b})
        s->edge = s->edge >= 0 ? first[s->panel][s->edge]
                               : edges_of(sewn_.panels[s->panel]) - 1 - s->edge;
      sewn_.stitches.push_back(std::move(stitch));
    }
  }

  std::vector<std::int32_t> divide(std::int32_t p) {
    PatternPanel& panel = sewn_.panels[p];
    const PatternPanel whole = panel;
    std::vector<std::int32_t> first;
    panel.edges.clear();
    for (std::int32_t e = 0; e < edges_of(whole); ++e) {
      first.push_back(edges_of(panel));
      const auto found = cuts_.find({p, e});
      if (found == cuts_.end()) {
        panel.edges.push_back(whole.edges[e]);
        continue;
      }
      const EdgeParts parts = split_edge(whole, e, found->second);
      std::int32_t from = whole.edges[e].endpoints[0];
      for (std::size_t i = 0; i < parts.curves.size(); ++i) {
        std::int32_t to = whole.edges[e].endpoints[1];
        if (i < parts.points.size()) {
          to = static_cast<std::int32_t>(panel.vertices.size());
          panel.vertices.push_back(parts.points[i]);
        }
        panel.edges.push_back(
            {{from, to}, parts.curves[i], whole.edges[e].label, whole.edges[e].elastic});
        from = to;
      }
    }
    return first;
  }

  struct Joint {
    Part a, b;
    bool same_way;
    PatternStitch::Closure closure;
    std::vector<double> buttons;
  };
  const DrawnPattern& drawn_;
  SewingPattern sewn_;
  std::vector<std::vector<Corner>> own_, other_;  // per drawn panel and edge
  std::map<Corner, std::vector<Notch>> notches_;
  std::map<Corner, std::vector<double>> cuts_;              // shares of length
  std::vector<std::vector<Corner>> own_line_, other_line_;  // per drawn panel and line
  std::set<Corner> taken_up_;                               // by pleats
  std::vector<Joint> joints_;
  std::vector<PatternStitch> line_stitches_;  // an edge below 0: line -1 - edge
};

}  // namespace

SewingPattern as_sewn(const DrawnPattern& drawn) {
  const DrawnPattern plain = with_pleats(drawn);
  return Sewer(plain).run();
}

}  // namespace selvedge
