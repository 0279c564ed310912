// SPDX-License-Identifier: MIT
//
// The origin of a pattern: half of the public bodies have theirs at the pelvis, the others between
// the feet, and a pattern that is drawn for one kind stands beside a body of the other.
#include <fmt/format.h>
#include <selvedge/dress/detail/origin.h>
#include <selvedge/dress/internal/arrange.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace selvedge::detail {
namespace {

constexpr double kUpsideDown = -0.5;  // mean height of what should point up

constexpr double kPelvis = 0.676;    // height of the pelvis, of that of the body (SMPL)
constexpr double kCentred = 0.1;     // m, of the middle of a body from an origin below it
constexpr double kSamples = 2000.0;  // points of each that are compared
constexpr double kFar = 0.1;         // m, mean distance of a pattern that may be at another place
constexpr double kNearer = 1.2;      // times nearer another place is, if it is the right one

struct Box {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
};

Box box_of(std::span<const Vec3> points) {
  Box box;
  for (const Vec3& p : points) {
    box.low = box.low.cwiseMin(p);
    box.high = box.high.cwiseMax(p);
  }
  return box;
}

/// Points of a surface, equally dense: those of the R2 sequence [Roberts, "The unreasonable
/// effectiveness of quasirandom sequences", 2018] in each triangle, by its area.
std::vector<Vec3> samples_of(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  const auto area_of = [&](const Triangle& t) {
    return 0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).norm();
  };
  double all = 0.0, so_far = 0.0;
  for (const Triangle& t : triangles) all += area_of(t);
  std::vector<Vec3> samples;
  for (const Triangle& t : triangles) {
    so_far += area_of(t);
    while (static_cast<double>(samples.size()) < kSamples * so_far / all) {
      const auto i = static_cast<double>(samples.size());
      double a = std::fmod(0.5 + 0.7548776662466927 * i, 1.0),
             b = std::fmod(0.5 + 0.5698402909980532 * i, 1.0);
      if (a + b > 1.0) a = 1.0 - a, b = 1.0 - b;
      samples.push_back(x[t[0]] + a * (x[t[1]] - x[t[0]]) + b * (x[t[2]] - x[t[0]]));
    }
  }
  return samples;
}

double mean_distance(std::span<const Vec3> points, const Vec3& by, std::span<const Vec3> body) {
  double sum = 0.0;
  for (const Vec3& p : points) {
    double least = std::numeric_limits<double>::infinity();
    for (const Vec3& x : body) least = std::min(least, (p + by - x).squaredNorm());
    sum += std::sqrt(least);
  }
  return sum / static_cast<double>(points.size());
}

double top_of(const PatternPanel& panel) {
  double highest = -std::numeric_limits<double>::infinity();
  for (const Vec2& x : panel.vertices) highest = std::max(highest, place_point(panel, x).z());
  return highest;
}

Vec3 middle_of(const PatternPanel& panel) {
  Vec3 sum = Vec3::Zero();
  for (const Vec2& x : panel.vertices) sum += place_point(panel, x);
  return sum / static_cast<double>(panel.vertices.size());
}

/// The direction of each panel of trunk and legs that `arrange` turns up: its height as it stands,
/// by area, in [-1, 1].
double mean_up(const SewingPattern& pattern, const Arrangement& arranged) {
  using Part = PanelRole::Part;
  double sum = 0.0, all = 0.0;
  for (std::size_t p = 0; p < arranged.roles.size(); ++p) {
    const Part part = arranged.roles[p].part;
    if (part != Part::torso && part != Part::skirt && part != Part::leg) continue;
    Vec3 up = arranged.pattern.panels[p].rotation.transpose() * Vec3::UnitZ();
    up.z() = 0.0;
    const double area = std::abs(panel_area(pattern.panels[p])) * up.norm();
    all += area;
    if (area > 0.0) sum += area * (pattern.panels[p].rotation * up.normalized()).z();
  }
  return all > 0.0 ? sum / all : 1.0;
}

}  // namespace

bool OriginFit::is_beside() const {
  return gap > kFar || (distance > kFar && distance > kNearer * distance_by);
}

std::string OriginFit::fault() const {
  if (origin.empty())
    return fmt::format(
        "the pattern stands beside the body: {:.2f} m are between their boxes; place it around the "
        "body",
        gap);
  const double beside = by.head<2>().norm(), up = by.z();
  const std::string way = std::abs(up) >= beside ? fmt::format("{:.2f} m {}", std::abs(up),
                                                               up > 0.0 ? "below" : "above")
                                                 : fmt::format("{:.2f} m beside", beside);
  return fmt::format(
      "the pattern stands {} its place on the body: it is drawn for a body whose origin is {}; "
      "give "
      "--fit-origin, which moves it as a whole, or a body with this origin",
      way, origin);
}

OriginFit fit_origin(const GarmentMesh& garment, const TriangleMesh& body) {
  const Box around = box_of(body.vertices), panels = box_of(garment.placed);
  const std::vector<Vec3> points = samples_of(garment.placed, garment.flat.triangles),
                          skin = samples_of(body.vertices, body.triangles);
  OriginFit fit;
  fit.gap = std::max(0.0, (panels.low - around.high).cwiseMax(around.low - panels.high).maxCoeff());
  fit.distance = fit.distance_by = mean_distance(points, fit.by, skin);
  Vec3 feet = 0.5 * (around.low + around.high);
  for (int k = 0; k < 2; ++k)
    if (std::abs(feet[k]) < kCentred) feet[k] = 0.0;
  feet.z() = around.low.z();
  const double height = around.high.z() - around.low.z();
  for (const auto& [origin, place] :
       {std::pair("at the pelvis", Vec3(feet + Vec3(0.0, 0.0, kPelvis * height))),
        std::pair("between the feet", feet)}) {
    const double distance = mean_distance(points, place, skin);
    if (distance >= fit.distance_by) continue;
    fit.by = place;
    fit.distance_by = distance;
    fit.origin = origin;
  }
  return fit;
}

PatternStand stand_of(const SewingPattern& pattern, const TriangleMesh& body,
                      const BodyLandmarks& landmarks) {
  using Part = PanelRole::Part;
  Arrangement arranged = arrange(pattern, body, landmarks);
  PatternStand stand;
  const auto has_part = [&](std::size_t p, std::span<const Part> parts) {
    return std::find(parts.begin(), parts.end(), arranged.roles[p].part) != parts.end();
  };
  for (const auto& parts : {std::vector{Part::torso}, {Part::skirt, Part::leg, Part::waistband}}) {
    std::vector<double> off;
    for (std::size_t p = 0; p < arranged.roles.size(); ++p)
      if (has_part(p, parts))
        off.push_back(top_of(arranged.pattern.panels[p]) - top_of(pattern.panels[p]));
    if (off.empty()) continue;
    const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
    std::nth_element(off.begin(), middle, off.end());
    stand.height = *middle;
    break;
  }
  for (std::size_t p = 0; p < arranged.roles.size(); ++p) {
    if (arranged.roles[p].part != Part::sleeve) continue;
    Vec3 off = middle_of(arranged.pattern.panels[p]) - middle_of(pattern.panels[p]) -
               stand.height * Vec3::UnitZ();
    off -= off.dot(landmarks.forward) * landmarks.forward;
    stand.sleeves = std::max(stand.sleeves, off.norm());
  }
  stand.is_upside_down = mean_up(pattern, arranged) < kUpsideDown;
  stand.arranged = std::move(arranged.pattern);
  return stand;
}

}  // namespace selvedge::detail
