// SPDX-License-Identifier: MIT
//
// Panels placed around a body: in planes before and behind trunk and legs, and bent around
// cylinders of trunk, neck and limbs.
#include <fmt/format.h>
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/dress/detail/panel_placer.h>
#include <selvedge/dress/internal/arrange.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace selvedge {
namespace {

using Part = PanelRole::Part;
using Side = PanelRole::Side;
using Face = PanelRole::Face;
using Direction = PatternStitch::Direction;
using detail::kBetter;
using detail::kPanelGap;

constexpr double kRound = 1.03;  // circumference of a cylinder over the width of its panels
constexpr double kOval = 1.3;    // farthest skin of a trunk or limb over its mean radius

Vec2 turned_left(const Vec2& v) { return {-v.y(), v.x()}; }

class Arranger : public detail::PanelPlacer {
 public:
  using PanelPlacer::PanelPlacer;

  Arrangement run() {
    choose_rings();
    place_planar();
    place_rings();
    const auto place_all = [&](Part part, auto place) {
      for (std::int32_t p = 0; p < count(); ++p)
        if (!placed_[p] && role(p).part == part) place(p);
    };
    place_all(Part::waistband, [&](std::int32_t p) { place_band(p, marks_.waist); });
    place_all(Part::collar, [&](std::int32_t p) { place_band(p, marks_.neck); });
    place_all(Part::hood, [&](std::int32_t p) { place_hood(p); });
    choose_arms();
    place_all(Part::sleeve, [&](std::int32_t p) { place_on_arm(p); });
    place_all(Part::cuff, [&](std::int32_t p) { place_on_arm(p); });
    place_all(Part::patch, [&](std::int32_t p) { place_patch(p); });
    for (std::int32_t p = 0; p < count(); ++p)
      if (!placed_[p]) place_in_plane(p);
    settle_directions();
    return std::move(result_);
  }

 private:
  // Trunk and legs, in planes.

  bool is_planar(std::int32_t p) const {
    const Part part = role(p).part;
    if (in_ring_[p]) return false;
    if (part == Part::torso || part == Part::skirt || part == Part::leg) return true;
    return (part == Part::waistband || part == Part::collar) && role(p).face != Face::none;
  }

  void choose_rings() {
    in_ring_.assign(result_.roles.size(), 0);
    for (const Part part : {Part::skirt, Part::torso}) {
      bool is_ring = false;
      for (std::int32_t p = 0; p < count(); ++p)
        is_ring = is_ring || (role(p).part == part && role(p).face == Face::none);
      for (std::int32_t p = 0; p < count(); ++p)
        if (is_ring && role(p).part == part) in_ring_[p] = 1;
    }
  }

  /// The panel with the longest seams to panels that have their places, or the one that begins.
  std::int32_t next_planar() const {
    std::int32_t best = -1;
    double most = 0.0;
    for (std::int32_t p = 0; p < count(); ++p) {
      if (placed_[p] || !is_planar(p)) continue;
      double length = 0.0;
      for (const Seam& seam : seams_of(p, false))
        if (!seam.partners.empty()) length += seam.length;
      if (length > most) most = length, best = p;
    }
    if (best >= 0) return best;
    double largest = 0.0;
    for (std::int32_t p = 0; p < count(); ++p) {
      if (placed_[p] || !is_planar(p)) continue;
      const double rank = (role(p).part == Part::torso ? 1e4 : 0.0) +
                          (role(p).part == Part::waistband ? 0.0 : 1e2) +
                          (role(p).face == Face::front ? 10.0 : 0.0) +
                          std::abs(panel_area(panel(p)));
      if (rank > largest) largest = rank, best = p;
    }
    return best;
  }

  void place_planar() {
    for (std::int32_t p = next_planar(); p >= 0; p = next_planar()) place_in_plane(p);
    for (const Face face : {Face::front, Face::back}) {
      const Vec3 normal = face == Face::front ? forward_ : Vec3(-forward_);
      double offset = -1e300;
      for (std::int32_t p = 0; p < count(); ++p)
        if (placed_[p] && outward_[p] == normal) offset = std::max(offset, skin_before(p));
      for (std::int32_t p = 0; p < count(); ++p)
        if (placed_[p] && outward_[p] == normal)
          panel(p).translation += (offset + config_.clearance) * normal;
    }
  }

  void place_in_plane(std::int32_t p) {
    if (role(p).face == Face::none) {
      role(p).face = Face::front;
      result_.notes.push_back(fmt::format(
          "panel \"{}\" stands in front, because nothing says where it belongs; give it a place in "
          "the table",
          panel(p).name));
    }
    const Vec3 normal = role(p).face == Face::front ? forward_ : Vec3(-forward_);
    const Fit best = turn_best(p, up_, normal);
    panel(p).translation += best.offset;
    placed_[p] = 1;
    if (best.length == 0.0) hang(p);
    if (side_sign(p) != 0.0) keep_side(p, normal);
    leave_gap(p, normal);
    panel(p).translation -= panel(p).translation.dot(normal) * normal;
    if (std::abs(panel(p).rotation.col(2).dot(normal)) < 0.5)
      result_.notes.push_back(fmt::format("panel \"{}\" is turned oddly", panel(p).name));
  }

  /// A panel without placed neighbours hangs from the neck or from the waist.
  void hang(std::int32_t p) {
    const auto [low, high] = span_in_space(p, up_);
    const auto [right, left] = span_in_space(p, left_);
    const bool from_neck = role(p).part == Part::torso;
    const Vec3 neck = 0.5 * (marks_.neck_side[0] + marks_.neck_side[1]);
    const double top =
        up_.dot(from_neck ? neck : marks_.waist.middle) + (from_neck ? kPanelGap : 0.0);
    panel(p).translation += (top - high) * up_;
    panel(p).translation += (left_.dot(marks_.waist.middle) - 0.5 * (left + right)) * left_;
  }

  /// Halves stay on their side of the body.
  void keep_side(std::int32_t p, const Vec3&) {
    const double sign = side_sign(p), middle = left_.dot(marks_.waist.middle);
    const double inner = span_in_space(p, sign * left_)[0];
    panel(p).translation += (sign * middle + 0.5 * kPanelGap - inner) * sign * left_;
  }

  /// Neighbours in one plane that are sewn together do not touch.
  void leave_gap(std::int32_t p, const Vec3& normal) {
    for (const Vec3& axis : {up_, left_}) {
      if (axis == left_ && side_sign(p) != 0.0) continue;
      double push = 0.0;
      for (const Seam& seam : seams_of(p, turned_[p] != 0)) {
        if (seam.partners.empty() || outward_[seam.other] != normal) continue;
        const auto own = span_in_space(p, axis), other = span_in_space(seam.other, axis);
        const double apart = own[0] + own[1] - other[0] - other[1];
        const double overlap = std::min(own[1], other[1]) - std::max(own[0], other[0]);
        const double share = overlap / std::min(own[1] - own[0], other[1] - other[0]);
        if (share < 0.3)
          push = (apart > 0.0 ? 1.0 : -1.0) * std::max(kPanelGap, kPanelGap + overlap);
      }
      panel(p).translation += push * axis;
    }
  }

  // Around cylinders.

  /// Farthest skin from the axis of the trunk between two heights, m, without the limbs.
  double trunk_radius(const BodyRing& ring) const {
    return kOval * ring.girth / (2.0 * std::numbers::pi);
  }

  /// Panels around the trunk, each beside the one to which it is sewn.
  void place_rings() {
    for (const Part part : {Part::torso, Part::skirt}) {
      const std::vector<std::int32_t> ring = ring_order(part);
      if (ring.empty()) continue;
      double around = 0.0;
      for (const std::int32_t p : ring) around += width(p);
      const BodyRing& hold = part == Part::torso ? marks_.bust : marks_.hips;
      const double radius = std::max(kRound * around / (2.0 * std::numbers::pi),
                                     trunk_radius(hold) + config_.clearance);
      double angle = 0.0;
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const std::int32_t p = ring[i];
        if (i > 0) angle += std::numbers::pi * (width(ring[i - 1]) + width(p)) / around;
        const Vec3 normal = elementary::cos(angle) * forward_ + elementary::sin(angle) * left_;
        place_on_trunk(p, normal, radius, hold);
      }
    }
  }

  void place_on_trunk(std::int32_t p, const Vec3& normal, double radius, const BodyRing& ring) {
    const Vec2 v(0.0, 1.0);
    turn(p, v, up_, normal, false);
    const auto [low, high] = span(p, v);
    const auto [left, right] = span(p, Vec2(1.0, 0.0));
    const Vec2 at(0.5 * (left + right), high);
    bend(p, v, at, radius);
    const bool is_torso = role(p).part == Part::torso;
    const Vec3 neck = 0.5 * (marks_.neck_side[0] + marks_.neck_side[1]);
    double top = up_.dot(is_torso ? neck : marks_.waist.middle);
    // Below what it is sewn to.
    for (const Seam& seam : seams_of(p, false))
      if (!seam.partners.empty() && role(seam.other).part != role(p).part)
        top = std::min(top, span_in_space(seam.other, up_)[0] - kPanelGap);
    const Vec3 across = ring.middle - ring.middle.dot(up_) * up_;
    move_to(p, at, across + top * up_ + radius * normal);
  }

  /// The panels of a ring from the front to the left.
  std::vector<std::int32_t> ring_order(Part part) const {
    std::vector<std::int32_t> ring;
    std::int32_t at = -1;
    for (std::int32_t p = 0; p < count(); ++p)
      if (in_ring_[p] && role(p).part == part && (at < 0 || role(p).face == Face::front)) at = p;
    while (at >= 0 && std::find(ring.begin(), ring.end(), at) == ring.end()) {
      ring.push_back(at);
      at = left_neighbour(at);
    }
    for (std::int32_t p = 0; p < count(); ++p)
      if (in_ring_[p] && role(p).part == part &&
          std::find(ring.begin(), ring.end(), p) == ring.end())
        ring.push_back(p);
    return ring;
  }

  /// Seen from outside, the wearer's left is on the right.
  std::int32_t left_neighbour(std::int32_t p) const {
    const double sign = sign_[p];
    const auto [low, high] = span(p, Vec2(1.0, 0.0));
    std::int32_t best = -1;
    double most = 0.0;
    for (const Seam& seam : seams_of(p, false)) {
      if (!in_ring_[seam.other] || role(seam.other).part != role(p).part) continue;
      Vec2 mean = Vec2::Zero();
      for (const Vec2& x : seam.own) mean += x / static_cast<double>(seam.own.size());
      const double beside = sign * (mean.x() - 0.5 * (low + high));
      if (beside * seam.length > most) most = beside * seam.length, best = seam.other;
    }
    return best;
  }

  /// A band in one piece around waist or neck. Its middle is behind, or where it is sewn to a
  /// front.
  void place_band(std::int32_t p, const BodyRing& ring) {
    const std::vector<Seam> seams = seams_of(p, false);
    Vec2 sewn = Vec2::Zero(), behind = Vec2::Zero();
    Vec3 partners = Vec3::Zero();
    double length = 0.0, back = 0.0;
    bool is_above = role(p).part == Part::collar;
    for (const Seam& seam : seams) {
      Vec2 mean = Vec2::Zero();
      for (const Vec2& x : seam.own) mean += x / static_cast<double>(seam.own.size());
      sewn += seam.length * mean;
      length += seam.length;
      for (const Vec3& x : seam.partners)
        partners += seam.length * x / static_cast<double>(seam.partners.size());
      if (role(seam.other).part != Part::torso) is_above = true;
      if (role(seam.other).face != Face::back) continue;
      behind += seam.length * mean;
      back += seam.length;
    }
    const auto [x0, x1] = span(p, Vec2(1.0, 0.0));
    const auto [y0, y1] = span(p, Vec2(0.0, 1.0));
    const Vec2 box(0.5 * (x0 + x1), 0.5 * (y0 + y1));
    const bool is_wide = x1 - x0 >= y1 - y0;
    Vec2 v = is_wide ? Vec2(0.0, 1.0) : Vec2(1.0, 0.0);
    if (length > 0.0 && v.dot(sewn / length - box) * (is_above ? 1.0 : -1.0) > 0.0) v = -v;
    const Vec3 normal = back > 0.0 ? Vec3(-forward_) : forward_;
    const Vec2 middle = back > 0.0 ? Vec2(behind / back) : box;
    turn(p, v, up_, normal, false);
    const double across = is_wide ? x1 - x0 : y1 - y0, high = is_wide ? y1 - y0 : x1 - x0;
    const double radius = std::max(kRound * across / (2.0 * std::numbers::pi),
                                   trunk_radius(ring) + 0.5 * config_.clearance);
    const Vec2 at = box + (middle - box).dot(turned_left(v)) * turned_left(v);
    bend(p, v, at, radius);
    double height = up_.dot(ring.middle);
    if (length > 0.0 && partners != Vec3::Zero())
      height = up_.dot(partners) / length + (is_above ? 1.0 : -1.0) * (0.5 * high + kPanelGap);
    if (role(p).part == Part::collar)
      height =
          up_.dot(0.5 * (marks_.neck_side[0] + marks_.neck_side[1])) + 0.5 * high + 2.0 * kPanelGap;
    move_to(p, at, ring.middle + (height - up_.dot(ring.middle)) * up_ + radius * normal);
  }

  // Hoods, sleeves, pockets.

  /// Half a hood stands beside the head.
  void place_hood(std::int32_t p) {
    if (side_sign(p) == 0.0) {
      role(p).side = Side::left;
      for (std::int32_t q = 0; q < count(); ++q)
        if (q != p && role(q).part == Part::hood && role(q).side == Side::left)
          role(p).side = Side::right;
    }
    const Vec3 normal = side_sign(p) * left_;
    const Fit best = turn_best(p, up_, normal);
    panel(p).translation += best.offset;
    placed_[p] = 1;
    const double bottom =
        up_.dot(0.5 * (marks_.neck_side[0] + marks_.neck_side[1])) + 2.0 * kPanelGap;
    const double low = span_in_space(p, up_)[0];
    panel(p).translation += std::max(0.0, bottom - low) * up_;
    panel(p).translation +=
        (skin_before(p) + 0.5 * config_.clearance - panel(p).translation.dot(normal)) * normal;
  }

  /// Sleeves without a side take that of the armholes to which they are sewn, else the free one.
  void choose_arms() {
    for (std::int32_t p = 0; p < count(); ++p) {
      if (role(p).part != Part::sleeve || side_sign(p) != 0.0) continue;
      double beside = 0.0;
      for (const Seam& seam : seams_of(p, false))
        for (const Vec3& x : seam.partners) beside += left_.dot(x - marks_.waist.middle);
      role(p).side = beside < 0.0 ? Side::right : Side::left;
    }
    for (std::int32_t p = 0; p < count(); ++p) {
      if (role(p).part != Part::cuff || side_sign(p) != 0.0) continue;
      role(p).side = Side::left;
      each_seam(p, [&](std::int32_t, const PatternStitch::Side& other, Direction) {
        if (other.panel != p && side_sign(other.panel) != 0.0)
          role(p).side = role(other.panel).side;
      });
    }
  }

  /// How a sleeve lies in its file: the direction from the cap to the hem, the middle of its seams
  /// along the arm, and the middle of the cap.
  struct SleeveAxis {
    Vec2 along = Vec2::Zero(), middle = Vec2::Zero(), cap = Vec2::Zero();
    double begin = 0.0;  // m, along `along`: where the seam along the arm begins
    bool is_tube = false;
  };
  SleeveAxis sleeve_axis(std::int32_t p) const {
    SleeveAxis axis;
    double cap = 0.0, seams = 0.0;
    std::vector<std::array<Vec2, 2>> lines;
    each_seam(p, [&](std::int32_t e, const PatternStitch::Side& other, Direction) {
      const auto add = [&](std::int32_t edge) {
        lines.push_back({edge_point(panel(p), edge, 0.0), edge_point(panel(p), edge, 1.0)});
      };
      const bool is_near = placed_[other.panel] && role(other.panel).part != role(p).part;
      if (is_near) {
        const double length = edge_length(panel(p), e);
        axis.cap += length * edge_point(panel(p), e, 0.5);
        cap += length;
      } else if (role(other.panel).part == role(p).part) {
        add(e);
        if (other.panel == p) add(other.edge), axis.is_tube = true;
      }
    });
    if (cap > 0.0) axis.cap /= cap;
    Vec2 sum = Vec2::Zero();
    for (auto& [start, end] : lines) {
      if ((start - axis.cap).norm() > (end - axis.cap).norm()) std::swap(start, end);
      const double length = (end - start).norm();
      sum += end - start;
      axis.middle += 0.5 * length * (start + end);
      seams += length;
    }
    axis.middle = seams > 0.0 ? Vec2(axis.middle / seams) : middle(p);
    axis.along = seams > 0.0 && sum.norm() > 0.2 * seams ? sum.normalized()
                                                         : Vec2(middle(p) - axis.cap).normalized();
    axis.begin = lines.empty() ? axis.along.dot(axis.cap) : 0.0;
    for (const auto& [start, end] : lines)
      axis.begin += axis.along.dot(start) / static_cast<double>(lines.size());
    return axis;
  }

  /// The face of half a sleeve whose name does not say it: of the panels to which it is sewn.
  Face face_of_half(std::int32_t p) const {
    double front = 0.0;
    for (const Seam& seam : seams_of(p, false))
      for (const Vec3& x : seam.partners) front += forward_.dot(x - marks_.waist.middle);
    return front >= 0.0 ? Face::front : Face::back;
  }

  void place_on_arm(std::int32_t p) {
    const BodyLimb& arm = marks_.arms[role(p).side == Side::left ? 0 : 1];
    const SleeveAxis sleeve = sleeve_axis(p);
    const auto [begin, end] = span(p, sleeve.along);
    // From the trunk, or from the end of the sleeve before a cuff.
    std::size_t first = 0;
    double at_begin = sleeve.begin;
    if (role(p).part == Part::cuff) {
      first = ring_at_partners(p, arm);
      at_begin = begin;
    }
    const auto length = static_cast<std::size_t>(std::max(0.08, end - at_begin) / 0.01);
    const std::size_t last = std::min(first + length, arm.rings.size() - 1);
    first = std::min(first, last > 8 ? last - 8 : 0);
    const Vec3 from = arm.rings[first].middle;
    const Vec3 axis = (arm.rings[last].middle - from).normalized();
    Vec3 fore = (forward_ - forward_.dot(axis) * axis).normalized();
    const double gap = role(p).part == Part::cuff ? kPanelGap : 2.0 * kPanelGap;
    const Vec2 across = turned_left(sleeve.along);
    if (sleeve.is_tube) {
      Vec3 top = axis.cross(fore);
      if (top.dot(2.0 * up_ + side_sign(p) * left_) < 0.0) top = -top;
      turn_sleeve(p, sleeve.along, axis, top);
      const auto [low, high] = span(p, across);
      double girth = 0.0;
      for (std::size_t i = first; i <= last; ++i) girth = std::max(girth, arm.rings[i].girth);
      const double radius = std::max(kRound * (high - low) / (2.0 * std::numbers::pi),
                                     kOval * girth / (2.0 * std::numbers::pi) + 0.01);
      const Vec2 at = sleeve.along * at_begin + across * across.dot(sleeve.middle);
      bend(p, sleeve.along, at, radius);
      move_to(p, at, from + gap * axis + radius * top);
      return;
    }
    if (role(p).face == Face::none) role(p).face = face_of_half(p);
    const Vec3 normal = role(p).face == Face::front ? fore : Vec3(-fore);
    turn_sleeve(p, sleeve.along, axis, normal);
    const Vec2 at = sleeve.along * at_begin + across * across.dot(sleeve.middle);
    move_to(p, at, from + gap * axis);
    panel(p).translation += (skin_before(p) - normal.dot(from) + 0.6 * config_.clearance) * normal;
  }

  /// Of both ways to lay a sleeve along its arm, if its file does not say which side is outside,
  /// the one whose seams fit.
  void turn_sleeve(std::int32_t p, const Vec2& along, const Vec3& axis, const Vec3& normal) {
    turn(p, along, axis, normal, true);
    const double over = fit(p, normal, seams_of(p, true)).residual;
    turn(p, along, axis, normal, false);
    const double plain = fit(p, normal, seams_of(p, false)).residual;
    if (leaves_side_open(p) && plain > kBetter * over + kPanelGap)
      turn(p, along, axis, normal, true);
  }

  /// The ring of an arm nearest to the edges to which a cuff is sewn.
  std::size_t ring_at_partners(std::int32_t p, const BodyLimb& arm) const {
    Vec3 sum = Vec3::Zero();
    double points = 0.0;
    for (const Seam& seam : seams_of(p, false))
      for (const Vec3& x : seam.partners) sum += x, points += 1.0;
    if (points == 0.0) return arm.rings.size() * 6 / 10;
    std::size_t best = 0;
    for (std::size_t i = 0; i < arm.rings.size(); ++i)
      if ((arm.rings[i].middle - sum / points).norm() <
          (arm.rings[best].middle - sum / points).norm())
        best = i;
    return best;
  }

  /// A pocket or a facing lies outside the panel to which it is sewn.
  void place_patch(std::int32_t p) {
    std::int32_t host = -1;
    double most = 0.0;
    for (const Seam& seam : seams_of(p, false))
      if (!seam.partners.empty() && seam.length > most) most = seam.length, host = seam.other;
    if (host < 0) {
      place_in_plane(p);
      return;
    }
    const Fit best = turn_best(p, up_, outward_[host]);
    panel(p).translation += best.offset;
    placed_[p] = 1;
    const Vec3 normal = outward_[host];
    panel(p).translation +=
        (normal.dot(panel(host).translation) + kPanelGap - normal.dot(panel(p).translation)) *
        normal;
  }

  /// Seams whose direction the file leaves open follow the sides of the panels.
  void settle_directions() {
    for (PatternStitch& s : result_.pattern.stitches)
      if (s.direction == Direction::unknown && !result_.pattern.is_on_a_line(s))
        s.direction = turned_[s.a.panel] == turned_[s.b.panel] ? Direction::end_to_start
                                                               : Direction::start_to_start;
  }
};

}  // namespace

Arrangement arrange(const SewingPattern& pattern, const TriangleMesh& body,
                    const BodyLandmarks& landmarks, const ArrangeConfig& config) {
  return Arranger(pattern, body, landmarks, config).run();
}

std::string arrangement_table(const Arrangement& arrangement) {
  std::string text;
  for (std::size_t p = 0; p < arrangement.roles.size(); ++p) {
    const PatternPanel& panel = arrangement.pattern.panels[p];
    text += fmt::format("panel        {:<20} {:<20} by {}{}\n", panel.name,
                        arrangement.roles[p].text(), arrangement.why[p],
                        panel.bend.radius != 0.0 ? fmt::format("; on a cylinder of {:.2f} m",
                                                               std::abs(panel.bend.radius))
                                                 : "");
  }
  for (const std::string& note : arrangement.notes) text += fmt::format("note         {}\n", note);
  return text;
}

SewingPattern turned_back(SewingPattern pattern, UpAxis up) {
  Mat3 turn = Mat3::Identity();
  if (up == UpAxis::x) turn << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  if (up == UpAxis::y) turn << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  for (PatternPanel& panel : pattern.panels) {
    panel.rotation = turn * panel.rotation;
    panel.translation = turn * panel.translation;
  }
  return pattern;
}

}  // namespace selvedge
