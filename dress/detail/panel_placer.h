// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/dress/internal/arrange.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace selvedge::detail {

inline constexpr double kPanelGap = 0.012;      // m, between two panels in one plane
inline constexpr std::int32_t kEdgePieces = 8;  // of an edge that is compared with another one
inline constexpr double kUpright = 0.97;        // cosine below which a trunk leans
inline constexpr double kBetter = 2.0;  // ratio of residuals at which a panel is turned over

/// Panels, the seams between them, and the moves that place one.
class PanelPlacer {
 public:
  PanelPlacer(const SewingPattern& pattern, const TriangleMesh& body, const BodyLandmarks& marks,
              const ArrangeConfig& config)
      : body_(body), marks_(marks), config_(config) {
    result_.pattern = pattern;
    result_.roles = panel_roles(pattern, config, result_.why);
    up_ = snapped_axis(marks.up);
    forward_ = snapped_axis((marks.forward - marks.forward.dot(up_) * up_).normalized());
    forward_ = (forward_ - forward_.dot(up_) * up_).normalized();
    left_ = up_.cross(forward_);
    const std::size_t n = pattern.panels.size();
    placed_.assign(n, 0);
    turned_.assign(n, 0);
    outward_.assign(n, Vec3::Zero());
    for (PatternPanel& panel : result_.pattern.panels) {
      panel.translation.setZero();
      panel.rotation.setIdentity();
      panel.bend = {};
      outline_.push_back(outline_of(panel));
      sign_.push_back(panel_area(panel) < 0.0 ? -1.0 : 1.0);
    }
  }

 protected:
  /// A direction that nearly agrees with an axis becomes the axis: panels then stand upright.
  static Vec3 snapped_axis(const Vec3& v) {
    Eigen::Index axis = 0;
    if (v.cwiseAbs().maxCoeff(&axis) < kUpright) return v;
    Vec3 snap = Vec3::Zero();
    snap[axis] = v[axis] > 0.0 ? 1.0 : -1.0;
    return snap;
  }

  // What is there.

  std::int32_t count() const { return static_cast<std::int32_t>(result_.roles.size()); }
  PatternPanel& panel(std::int32_t p) { return result_.pattern.panels[p]; }
  const PatternPanel& panel(std::int32_t p) const { return result_.pattern.panels[p]; }
  PanelRole& role(std::int32_t p) { return result_.roles[p]; }
  const PanelRole& role(std::int32_t p) const { return result_.roles[p]; }

  static std::vector<Vec2> outline_of(const PatternPanel& panel) {
    std::vector<Vec2> points;
    for (std::int32_t e = 0; e < static_cast<std::int32_t>(panel.edges.size()); ++e) {
      const std::vector<Vec2> line = divide_edge(panel, e, kEdgePieces);
      points.insert(points.end(), line.begin(), line.end() - 1);
    }
    return points;
  }

  /// Least and greatest coordinate of a panel along a direction of its plane, m.
  std::array<double, 2> span(std::int32_t p, const Vec2& direction) const {
    std::array<double, 2> range = {1e300, -1e300};
    for (const Vec2& x : outline_[p]) {
      range[0] = std::min(range[0], direction.dot(x));
      range[1] = std::max(range[1], direction.dot(x));
    }
    return range;
  }
  Vec2 middle(std::int32_t p) const {
    Vec2 sum = Vec2::Zero();
    for (const Vec2& x : outline_[p]) sum += x;
    return sum / static_cast<double>(outline_[p].size());
  }

  /// A seam of panel p: its own edge, and where the points stand to which it is sewn.
  struct Seam {
    std::int32_t edge = 0, other = 0, other_edge = 0;
    double length = 0.0;         // m
    std::vector<Vec2> own;       // m, equally far apart
    std::vector<Vec3> partners;  // m, empty unless the other panel has its place
  };

  template <class F>
  void each_seam(std::int32_t p, const F& visit) const {
    for (const PatternStitch& s : result_.pattern.stitches) {
      if (s.a.panel == p) visit(s.a.edge, s.b, s.direction);
      if (s.b.panel == p && s.a.panel != p) visit(s.b.edge, s.a, s.direction);
    }
  }

  /// The seams of a panel with others. `is_turned`: its loop shows its inner side.
  std::vector<Seam> seams_of(std::int32_t p, bool is_turned) const {
    std::vector<Seam> seams;
    each_seam(p, [&](std::int32_t edge, const PatternStitch::Side& other,
                     PatternStitch::Direction direction) {
      if (other.panel == p) return;
      Seam seam{edge, other.panel, other.edge, edge_length(panel(p), edge), {}, {}};
      if (panel(p).is_line(edge) || panel(other.panel).is_line(other.edge)) {
        // Either way round: the middles meet.
        seam.own = {edge_point(panel(p), edge, 0.5)};
        if (placed_[other.panel])
          seam.partners = {
              place_point(panel(other.panel), edge_point(panel(other.panel), other.edge, 0.5))};
        return seams.push_back(std::move(seam));
      }
      seam.own = divide_edge(panel(p), edge, kEdgePieces);
      if (placed_[other.panel]) {
        bool same = direction == PatternStitch::Direction::start_to_start;
        if (direction == PatternStitch::Direction::unknown)
          same = is_turned != (turned_[other.panel] != 0);
        for (const Vec2& x : divide_edge(panel(other.panel), other.edge, kEdgePieces))
          seam.partners.push_back(place_point(panel(other.panel), x));
        if (!same) std::reverse(seam.partners.begin(), seam.partners.end());
      }
      seams.push_back(std::move(seam));
    });
    return seams;
  }

  // Placing.

  /// Turns a panel so that the direction `v` of its plane points along `axis` and its outer side
  /// along `normal`.
  void turn(std::int32_t p, const Vec2& v, const Vec3& axis, const Vec3& normal, bool is_turned) {
    const Vec3 z = (is_turned ? -sign_[p] : sign_[p]) * normal, across = z.cross(axis);
    Mat3 to, from;
    to << axis, across, z;
    from << Vec3(v.x(), v.y(), 0.0), Vec3(-v.y(), v.x(), 0.0), Vec3::UnitZ();
    panel(p).rotation = to * from.transpose();
    turned_[p] = is_turned ? 1 : 0;
    outward_[p] = normal;
  }

  void move_to(std::int32_t p, const Vec2& point, const Vec3& place) {
    panel(p).translation += place - place_point(panel(p), point);
    placed_[p] = 1;
  }

  /// Mean offset of the partners of all seams from this panel as it is turned, and the root of the
  /// mean square that remains across `normal`, m.
  struct Fit {
    Vec3 offset = Vec3::Zero();
    double residual = 0.0;
    double length = 0.0;  // m, of these seams
  };
  Fit fit(std::int32_t p, const Vec3& normal, const std::vector<Seam>& seams) const {
    Fit fit;
    double square = 0.0;
    for (const Seam& seam : seams)
      for (std::size_t i = 0; i < seam.partners.size(); ++i) {
        Vec3 offset = seam.partners[i] - place_point(panel(p), seam.own[i]);
        offset -= offset.dot(normal) * normal;
        const double weight = seam.length / static_cast<double>(seam.partners.size());
        fit.offset += weight * offset;
        square += weight * offset.squaredNorm();
        fit.length += weight;
      }
    if (fit.length == 0.0) return fit;
    fit.offset /= fit.length;
    fit.residual = std::sqrt(std::max(0.0, square / fit.length - fit.offset.squaredNorm()));
    return fit;
  }

  /// The seams that show how a panel is turned. A curve that meets its mirror image, as at a
  /// crotch, does not: it fits best when the other half is turned by twice its slope.
  std::vector<Seam> turning_seams(std::int32_t p, bool is_turned) const {
    std::vector<Seam> seams = seams_of(p, is_turned);
    std::erase_if(seams, [&](const Seam& seam) {
      const PanelRole &own = role(p), &other = role(seam.other);
      return own.part == other.part && own.face == other.face &&
             own.side != PanelRole::Side::none && other.side != PanelRole::Side::none &&
             own.side != other.side;
    });
    return seams;
  }

  /// Turns a panel in its plane by a quarter until its seams lie best; the axes of the file are
  /// those of the grain. Panels whose seams do not say which ends meet may be turned over.
  Fit turn_best(std::int32_t p, const Vec3& axis, const Vec3& normal) {
    struct Choice {
      Vec2 v;
      bool is_turned;
      double residual;
    };
    std::vector<Choice> choices;
    const bool may_turn = leaves_side_open(p);
    for (const bool is_turned : {false, true})
      for (const Vec2& v : {Vec2(0.0, 1.0), Vec2(0.0, -1.0), Vec2(1.0, 0.0), Vec2(-1.0, 0.0)}) {
        turn(p, v, axis, normal, is_turned);
        choices.push_back({v, is_turned, fit(p, normal, turning_seams(p, is_turned)).residual});
      }
    const auto least = [](auto first, auto last) {
      return *std::min_element(first, last, [](const Choice& a, const Choice& b) {
        return a.residual < b.residual - 1e-9;
      });
    };
    Choice best = least(choices.begin(), choices.begin() + 4);
    const Choice over = least(choices.begin() + 4, choices.end());
    if (may_turn && best.residual > kBetter * over.residual + kPanelGap) best = over;
    turn(p, best.v, axis, normal, best.is_turned);
    return fit(p, normal, seams_of(p, best.is_turned));
  }

  /// The file does not say which ends of the seams of a panel meet.
  bool leaves_side_open(std::int32_t p) const {
    bool is_open = false;
    each_seam(
        p, [&](std::int32_t, const PatternStitch::Side& other, PatternStitch::Direction direction) {
          is_open = is_open || (other.panel != p && direction == PatternStitch::Direction::unknown);
        });
    return is_open;
  }

  double side_sign(std::int32_t p) const {
    return role(p).side == PanelRole::Side::left    ? 1.0
           : role(p).side == PanelRole::Side::right ? -1.0
                                                    : 0.0;
  }

  std::array<double, 2> span_in_space(std::int32_t p, const Vec3& direction) const {
    std::array<double, 2> range = {1e300, -1e300};
    for (const Vec2& x : outline_[p]) {
      const double at = direction.dot(place_point(panel(p), x));
      range = {std::min(range[0], at), std::max(range[1], at)};
    }
    return range;
  }

  /// Farthest skin along the outward normal of a panel, of what it covers, m.
  double skin_before(std::int32_t p) const {
    const Vec3 normal = outward_[p], u = normal.unitOrthogonal(), v = normal.cross(u);
    const auto [u0, u1] = span_in_space(p, u);
    const auto [v0, v1] = span_in_space(p, v);
    double most = -1e300;
    for (const Vec3& x : body_.vertices)
      if (u.dot(x) >= u0 - kPanelGap && u.dot(x) <= u1 + kPanelGap && v.dot(x) >= v0 - kPanelGap &&
          v.dot(x) <= v1 + kPanelGap)
        most = std::max(most, normal.dot(x));
    return most > -1e299 ? most : normal.dot(marks_.waist.middle);
  }

  /// Bends a panel around a cylinder whose axis is the direction `v` of its plane; `at` keeps its
  /// place.
  void bend(std::int32_t p, const Vec2& v, const Vec2& at, double radius) {
    const double z = turned_[p] ? -sign_[p] : sign_[p];
    panel(p).bend = {z * radius, at, v};
  }

  double width(std::int32_t p) const {
    const auto [low, high] = span(p, Vec2(1.0, 0.0));
    return high - low;
  }

  const TriangleMesh& body_;
  const BodyLandmarks& marks_;
  const ArrangeConfig& config_;
  Arrangement result_;
  Vec3 up_, left_, forward_;
  std::vector<std::vector<Vec2>> outline_;  // m, per panel
  std::vector<double> sign_;                // per panel: 1 if its loop runs counter-clockwise
  std::vector<char> placed_, turned_, in_ring_;
  std::vector<Vec3> outward_;
};

}  // namespace selvedge::detail
