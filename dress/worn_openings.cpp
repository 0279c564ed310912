// SPDX-License-Identifier: MIT
//
// A garment that has closed beside an arm looks well made: clean, sewn, at rest, its panels near
// their places. A tailor sees the empty sleeve. Head, arms and legs each leave a worn garment
// through an opening, and every opening is there for one of them, so an opening through which
// nothing leads is a fault. The openings are the borders of the sewn mesh; a part leads through one
// if its middle line crosses a surface that the border spans.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/dress/detail/deformation.h>
#include <selvedge/dress/detail/worn_openings.h>
#include <selvedge/dress/internal/arrange.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>

namespace selvedge::detail {
namespace {

constexpr double kBeyond = 0.15;                 // m, that the ways lead beyond hands and toes
constexpr double kBeyondFace = 0.3;              // m, from the middle of the head
constexpr std::array kFace = {0.25, 0.4, 0.55};  // of the way from the neck to the top: the face
constexpr double kBelowFoot = 0.2;               // m, from the ankle
constexpr double kLeastOpening = 0.15;           // m around; no hand passes through a smaller one
/// Total turn of a border along its cloth, below which it is a hole in it, rad. A hole in a plane
/// has -360 degrees, one on a shoulder less, the end of a tube 0, the armhole of two panels -180.
constexpr double kHole = -1.25 * std::numbers::pi;
constexpr double kFaces = 0.3;   // mean cosine at which a panel lies on a side of the body
constexpr double kInward = 0.5;  // mean cosine at which its outer side is turned to the trunk

/// Six times the volume of a tetrahedron.
double volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).cross(c - a).dot(d - a);
}

Vec3 middle_of(std::span<const Vec3> loop) {
  Vec3 sum = Vec3::Zero();
  double length = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec3 &a = loop[i], &b = loop[(i + 1) % loop.size()];
    sum += 0.5 * (b - a).norm() * (a + b);
    length += (b - a).norm();
  }
  return length > 0.0 ? Vec3(sum / length) : loop.front();
}

void append_limb(const BodyLimb& limb, std::vector<Vec3>& way) {
  for (const BodyRing& ring : limb.rings) way.push_back(ring.middle);
  way.push_back(limb.tip);
}

/// Straight on from the end of a way.
void lead_on(std::vector<Vec3>& way, const Vec3& direction, double by) {
  way.push_back(way.back() + by * direction.normalized());
}

/// The middle line of the trunk, upward, between legs and arms.
std::array<Vec3, 4> trunk_line(const BodyLandmarks& m) {
  return {0.5 * (m.legs[0].rings.front().middle + m.legs[1].rings.front().middle), m.hips.middle,
          m.waist.middle, m.bust.middle};
}

struct TrunkPoint {
  Vec3 at = Vec3::Zero();
  std::size_t above = 1;  // the next point of the line
};

TrunkPoint nearest_on(const std::array<Vec3, 4>& line, const Vec3& point) {
  TrunkPoint nearest;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vec3 way = line[i] - line[i - 1];
    const double share =
        std::clamp((point - line[i - 1]).dot(way) / std::max(way.squaredNorm(), 1e-12), 0.0, 1.0);
    const Vec3 at = line[i - 1] + share * way;
    if ((point - at).norm() >= least) continue;
    least = (point - at).norm();
    nearest = {at, i};
  }
  return nearest;
}

/// The openings of a garment and what leads through them.
class Openings {
 public:
  Openings(const Garment& start, const Garment& worn, const BodyLandmarks& landmarks,
           DressResult& result)
      : start_(start), worn_(worn), marks_(landmarks), result_(result) {
    Vec3 sum = Vec3::Zero();
    double area = 0.0;
    for (std::size_t i = 0; i < worn.surface.triangles.size(); ++i) {
      const double a = deformation(worn.surface, worn.flat, i).area;
      for (const std::int32_t v : worn.surface.triangles[i])
        sum += a / 3.0 * worn.surface.vertices[v];
      area += a;
    }
    turned_.assign(worn.surface.vertices.size(), std::numbers::pi);
    for (std::size_t i = 0; i < worn.flat.triangles.size(); ++i)
      for (int k = 0; k < 3; ++k)
        turned_[worn.surface.triangles[i][k]] -= angle_at(worn.flat, i, k);
    ends_ = body_ends(landmarks, area > 0.0 ? Vec3(sum / area) : Vec3::Zero());
  }

  void measure() {
    for (const BorderLoop& loop : border_loops(worn_.surface.triangles)) {
      const GarmentOpening opening = opening_of(loop);
      if (opening.length < kLeastOpening) continue;
      if (has_left_hood(loop)) result_.misworn.push_back({WornFault::Kind::hood, opening.panel});
      result_.openings.push_back(opening);
    }
    find_holes();
    find_faces();
    find_turns();
  }

 private:
  /// Of a triangle at its corner k, rad.
  static double angle_at(const TriangleMesh& flat, std::size_t i, int k) {
    const Triangle& t = flat.triangles[i];
    const Vec3 u = flat.vertices[t[(k + 1) % 3]] - flat.vertices[t[k]],
               v = flat.vertices[t[(k + 2) % 3]] - flat.vertices[t[k]];
    return elementary::atan2(u.cross(v).norm(), u.dot(v));
  }

  /// Empty openings that are holes in the cloth. Head or arms must have come out of their own: the
  /// neck of a garment beside the body turns as a hole does.
  void find_holes() {
    const auto leads = [](const GarmentOpening& opening, const std::string& end) {
      return std::any_of(opening.parts.begin(), opening.parts.end(), [&](const std::string& part) {
        return part.size() >= end.size() &&
               part.compare(part.size() - end.size(), end.size(), end) == 0;
      });
    };
    bool has_head = false;
    int arms = 0;
    for (const GarmentOpening& opening : result_.openings) {
      has_head = has_head || (leads(opening, "head") && !leads(opening, "leg"));
      arms += opening.parts.size() == 1 && leads(opening, "arm") ? 1 : 0;
    }
    for (GarmentOpening& opening : result_.openings)
      opening.is_hole = opening.is_hole && opening.parts.empty() && (has_head || arms == 2);
  }

  GarmentOpening opening_of(const BorderLoop& loop) const {
    GarmentOpening opening;
    std::map<std::int32_t, double> of_panel;
    double turn = 0.0;
    for (const auto& [t, k] : loop) {
      const Triangle& flat = worn_.flat.triangles[t];
      const double length =
          (worn_.flat.vertices[flat[(k + 1) % 3]] - worn_.flat.vertices[flat[k]]).norm();
      opening.length += length;
      of_panel[worn_.panel_of_triangle[t]] += length;
      turn += turned_[worn_.surface.triangles[t][k]];
    }
    opening.is_hole = turn < kHole;
    double most = 0.0;
    for (const auto& [panel, length] : of_panel)
      if (length > most) most = length, opening.panel = panel;
    const std::vector<Vec3> x = worn_points(loop);
    opening.at = middle_of(x);
    std::set<int> counts;
    for (const BodyEnd& end : ends_) {
      bool is_through = false;
      for (const std::vector<Vec3>& way : end.ways) {
        const int count = crossings(x, way);
        counts.insert(count);
        is_through = is_through || count != 0;
      }
      if (is_through) opening.parts.push_back(end.name);
    }
    // All ways alike: whatever surface the border spans, none is separated from another by it.
    if (counts.size() < 2) opening.parts.clear();
    return opening;
  }

  std::vector<Vec3> worn_points(const BorderLoop& loop) const {
    std::vector<Vec3> x;
    for (const auto& [t, k] : loop)
      x.push_back(worn_.surface.vertices[worn_.surface.triangles[t][k]]);
    return x;
  }

  /// The same line in the pattern as it is placed; empty if it does not lie on its panels.
  std::vector<Vec3> placed_points(const BorderLoop& loop) const {
    std::vector<Vec3> x;
    for (const auto& [t, k] : loop) {
      const std::int32_t v = worn_.flat.triangles[t][k];  // those of the coarse mesh come first
      if (static_cast<std::size_t>(v) < start_.corner.size())
        x.push_back(start_.surface.vertices[start_.corner[v]]);
    }
    return x;
  }

  /// Whether the head has come out of a border that left only its face free.
  bool has_left_hood(const BorderLoop& loop) const {
    const auto covers = [&](const std::vector<Vec3>& x) {
      const std::vector<std::vector<Vec3>>& ways = ends_.front().ways;
      return x.size() > 2 && crossings(x, ways[0]) == 0 &&
             std::any_of(ways.begin() + 1, ways.end(),
                         [&](const std::vector<Vec3>& face) { return crossings(x, face) != 0; });
    };
    return covers(placed_points(loop)) && !covers(worn_points(loop));
  }

  /// Panels whose names say front or back and that lie on the other side. The outer side of a
  /// facing is turned to the body.
  void find_faces() {
    const std::array<Vec3, 4> trunk = trunk_line(marks_);
    std::vector<double> sum(result_.panel_names.size(), 0.0), area = sum, outward = sum;
    for (std::size_t i = 0; i < worn_.surface.triangles.size(); ++i) {
      const Triangle& t = worn_.surface.triangles[i];
      const std::vector<Vec3>& x = worn_.surface.vertices;
      const Vec3 normal = 0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
      const auto p = static_cast<std::size_t>(worn_.panel_of_triangle[i]);
      const Vec3 middle = (x[t[0]] + x[t[1]] + x[t[2]]) / 3.0;
      sum[p] += normal.dot(marks_.forward);
      outward[p] += normal.dot((middle - nearest_on(trunk, middle).at).normalized());
      area[p] += normal.norm();
    }
    for (std::size_t p = 0; p < sum.size(); ++p) {
      const PanelRole role = role_of_name(result_.panel_names[p]);
      const double sign = role.face == PanelRole::Face::front  ? 1.0
                          : role.face == PanelRole::Face::back ? -1.0
                                                               : 0.0;
      const double face = outward[p] < -kInward * area[p] ? -sum[p] : sum[p];
      if (role.part == PanelRole::Part::hood || sign * face >= -kFaces * area[p]) continue;
      result_.misworn.push_back({sign > 0.0 ? WornFault::Kind::at_back : WornFault::Kind::in_front,
                                 static_cast<std::int32_t>(p)});
    }
  }

  /// The rotation that takes each panel best from where it is placed to where it is worn [Kabsch,
  /// "A solution for the best rotation to relate two sets of vectors", 1976].
  void find_turns() {
    const std::size_t panels = result_.panel_names.size();
    std::vector<std::set<std::int32_t>> vertices(panels);
    for (std::size_t i = 0; i < start_.flat.triangles.size(); ++i)
      for (const std::int32_t v : start_.flat.triangles[i])
        vertices[static_cast<std::size_t>(start_.panel_of_triangle[i])].insert(v);
    for (const std::set<std::int32_t>& own : vertices) {
      Vec3 placed = Vec3::Zero(), now = Vec3::Zero();
      for (const std::int32_t v : own) {
        placed += start_.surface.vertices[start_.corner[v]] / static_cast<double>(own.size());
        now += worn_.surface.vertices[worn_.corner[v]] / static_cast<double>(own.size());
      }
      Mat3 sum = Mat3::Zero();
      for (const std::int32_t v : own)
        sum += (worn_.surface.vertices[worn_.corner[v]] - now) *
               (start_.surface.vertices[start_.corner[v]] - placed).transpose();
      const Eigen::JacobiSVD<Mat3> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
      Mat3 sign = Mat3::Identity();
      sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant();
      const Mat3 turn = svd.matrixU() * sign * svd.matrixV().transpose();
      result_.panel_turned.push_back(
          elementary::acos(std::clamp(0.5 * (turn.trace() - 1.0), -1.0, 1.0)));
    }
    // One that has turned over while it was put on hangs well.
    if (std::all_of(result_.panel_turned.begin(), result_.panel_turned.end(),
                    [](double angle) { return angle > 0.5 * std::numbers::pi; }))
      result_.is_upside_down = false;
  }

  const Garment &start_, &worn_;
  const BodyLandmarks& marks_;
  DressResult& result_;
  std::vector<BodyEnd> ends_;
  std::vector<double> turned_;  // rad, of each vertex of the surface: π less the angles around it
};

}  // namespace

std::vector<BodyEnd> body_ends(const BodyLandmarks& m, const Vec3& middle) {
  const std::array<Vec3, 4> line = trunk_line(m);
  const TrunkPoint from = nearest_on(line, middle);
  std::vector<Vec3> up = {from.at}, down = {from.at};
  for (std::size_t i = from.above; i < line.size(); ++i) up.push_back(line[i]);
  for (std::size_t i = from.above; i-- > 0;) down.push_back(line[i]);
  std::vector<BodyEnd> ends(1);
  ends[0].name = "head";
  std::vector<Vec3> neck = up;
  for (const BodyRing& ring : {m.neck_base, m.neck}) neck.push_back(ring.middle);
  const auto add_way = [&](double share, const Vec3& direction, double by) {
    std::vector<Vec3> way = neck;
    way.push_back(m.neck.middle + share * (m.top - m.neck.middle));
    lead_on(way, direction, by);
    ends[0].ways.push_back(std::move(way));
  };
  add_way(0.5, m.up, kBeyond + 0.5 * (m.top - m.neck.middle).norm());
  for (const double share : kFace) add_way(share, m.forward, kBeyondFace);
  for (int k = 0; k < 2; ++k) {
    std::vector<Vec3> arm = up;
    // Straight from a bust far below it, the way would leave the trunk below the armpit.
    arm.push_back(0.5 * (m.armpit[k] + m.shoulder[k]));
    append_limb(m.arms[k], arm);
    lead_on(arm, m.arms[k].tip - m.arms[k].lower.middle, kBeyond);
    ends.push_back({k == 0 ? "left arm" : "right arm", {std::move(arm)}});
  }
  for (int k = 0; k < 2; ++k) {
    const BodyLimb& limb = m.legs[k];
    std::vector<Vec3> toes = down, sole = down;
    append_limb(limb, toes);
    lead_on(toes, limb.tip - limb.lower.middle, kBeyond);
    for (const BodyRing& ring : limb.rings) {
      sole.push_back(ring.middle);
      if (ring.middle == limb.lower.middle) break;
    }
    lead_on(sole, limb.lower.middle - limb.upper.middle, kBelowFoot);
    ends.push_back({k == 0 ? "left leg" : "right leg", {std::move(toes), std::move(sole)}});
  }
  return ends;
}

std::vector<BorderLoop> border_loops(std::span<const Triangle> triangles) {
  std::map<Edge, std::pair<std::int32_t, int>> half;  // from, to: triangle, and corner of `from`
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (int k = 0; k < 3; ++k)
      half[{triangles[i][k], triangles[i][(k + 1) % 3]}] = {static_cast<std::int32_t>(i), k};
  const auto is_border = [&](const Edge& e) { return !half.contains({e[1], e[0]}); };
  std::set<Edge> used;
  std::vector<BorderLoop> loops;
  for (const auto& [first, place] : half) {
    if (!is_border(first) || used.contains(first)) continue;
    BorderLoop loop;
    Edge edge = first;
    std::size_t steps = 0;
    while (used.insert(edge).second && steps <= half.size()) {
      loop.push_back(half.at(edge));
      // The next edge of the triangle, or of the last one around its vertex.
      const auto after = [&](const Edge& e) {
        const auto [t, k] = half.at(e);
        return Edge{triangles[t][(k + 1) % 3], triangles[t][(k + 2) % 3]};
      };
      edge = after(edge);
      while (!is_border(edge) && ++steps <= half.size()) edge = after({edge[1], edge[0]});
    }
    if (steps <= half.size()) loops.push_back(std::move(loop));
  }
  return loops;
}

int crossings(std::span<const Vec3> loop, std::span<const Vec3> way) {
  const Vec3 middle = middle_of(loop);
  int count = 0;
  for (std::size_t s = 1; s < way.size(); ++s) {
    const Vec3 &a = way[s - 1], &b = way[s];
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vec3 &p = loop[i], &q = loop[(i + 1) % loop.size()];
      // The line pierces the triangle if it passes all sides in the same sense.
      const bool first = volume(a, b, middle, p) >= 0.0, second = volume(a, b, p, q) >= 0.0,
                 third = volume(a, b, middle, q) < 0.0;
      if (first != second || second != third) continue;
      if ((volume(middle, p, q, a) >= 0.0) == (volume(middle, p, q, b) >= 0.0)) continue;
      count += first ? 1 : -1;
    }
  }
  return count;
}

void measure_openings(const Garment& start, const Garment& worn, const BodyLandmarks& landmarks,
                      DressResult& result) {
  Openings(start, worn, landmarks, result).measure();
}

}  // namespace selvedge::detail
