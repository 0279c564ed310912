// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/dress/detail/skin_distance.h>
#include <selvedge/dress/internal/landmarks.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace selvedge {
namespace {

using Point = Eigen::Vector2d;

/// Length of the hull of some points from the hull point nearest to one point to that nearest to
/// another, counter-clockwise.
double tape(const std::vector<Point>& hull, const Point& from, const Point& to) {
  const auto nearest = [&](const Point& p) {
    return static_cast<std::size_t>(std::min_element(hull.begin(), hull.end(),
                                                     [&](const Point& a, const Point& b) {
                                                       return (a - p).squaredNorm() <
                                                              (b - p).squaredNorm();
                                                     }) -
                                    hull.begin());
  };
  double length = 0.0;
  const std::size_t last = nearest(to);
  for (std::size_t i = nearest(from); i != last; i = (i + 1) % hull.size())
    length += (hull[(i + 1) % hull.size()] - hull[i]).norm();
  return length;
}

class Tailor {
 public:
  Tailor(const TriangleMesh& body, const BodyLandmarks& marks)
      : body_(detail::largest_part(body)), m_(marks) {}

  std::vector<BodyMeasure> measure() {
    add("chest", m_.bust.girth);
    add("waist", m_.waist.girth);
    add("seat", m_.hips.girth);
    add("neck", 0.5 * (m_.neck.girth + m_.neck_base.girth));
    arms();
    trunk();
    legs();
    return std::move(measures_);
  }

 private:
  void add(const char* name, double value) { measures_.push_back({name, value}); }
  double height(const Vec3& x) const { return m_.up.dot(x); }

  void arms() {
    add("biceps", 0.5 * (m_.arms[0].upper.girth + m_.arms[1].upper.girth));
    add("wrist", 0.5 * (m_.arms[0].lower.girth + m_.arms[1].lower.girth));
    add("shoulderToWrist", 0.5 * (m_.shoulder_to_wrist[0] + m_.shoulder_to_wrist[1]));
    add("shoulderToShoulder", (m_.shoulder[0] - m_.shoulder[1]).norm());
    double slope = 0.0;
    for (int k = 0; k < 2; ++k) {
      const Vec3 along = m_.shoulder[k] - m_.neck_side[k];
      slope += 0.5 * elementary::atan2(-m_.up.dot(along), std::abs(m_.left.dot(along)));
    }
    measures_.push_back({"shoulderSlope", slope, true});
  }

  /// Points of the section of the body where `direction` has this coordinate, between two heights,
  /// as (forward or left, up).
  std::vector<Point> section(const Vec3& direction, double at, const Vec3& across, double low,
                             double high) const {
    std::vector<double> value;
    for (const Vec3& x : body_.vertices) value.push_back(direction.dot(x));
    std::vector<Point> points;
    for (const detail::SkinLoop& loop : detail::level_loops(body_, value, at))
      for (const Vec3& x : loop.points)
        if (height(x) >= low && height(x) <= high) points.emplace_back(across.dot(x), height(x));
    if (points.size() < 3)
      throw std::invalid_argument("the measures of the body: its skin has a hole in a section");
    return points;
  }

  /// A tape down the front or the back through the side of the neck, between two heights.
  double down(bool in_front, double low, double high) const {
    double sum = 0.0;
    for (int k = 0; k < 2; ++k) {
      const Vec3 side = m_.neck_side[k];
      std::vector<Point> points =
          section(m_.left, m_.left.dot(side), m_.forward, low, std::min(high, height(side)));
      const double middle = m_.forward.dot(side);
      std::erase_if(points, [&](const Point& p) { return (p.x() > middle) != in_front; });
      points.emplace_back(middle, height(side));
      const std::vector<Point> hull = detail::hull_around(points);
      const auto lowest =
          std::min_element(hull.begin(), hull.end(), [&](const Point& a, const Point& b) {
            const double sign = in_front ? 1.0 : -1.0;
            return a.y() - 0.5 * sign * a.x() < b.y() - 0.5 * sign * b.x();
          });
      const Point top(middle, height(side));
      sum += in_front ? tape(hull, *lowest, top) : tape(hull, top, *lowest);
    }
    return 0.5 * sum;
  }

  /// The horizontal section of the trunk at a height: its girth, and the part behind the sides.
  struct Round {
    double girth = 0.0, back = 0.0;
  };
  Round round(double at) const {
    std::vector<double> heights;
    for (const Vec3& x : body_.vertices) heights.push_back(height(x));
    const Vec3 middle = m_.waist.middle;
    Round best;
    for (const detail::SkinLoop& loop : detail::level_loops(body_, heights, at)) {
      std::vector<Point> points;
      for (const Vec3& x : loop.points)
        points.emplace_back(m_.left.dot(x - middle), m_.forward.dot(x - middle));
      const std::vector<Point> hull = detail::hull_around(points);
      const auto [right, left] = std::minmax_element(
          hull.begin(), hull.end(), [](const Point& a, const Point& b) { return a.x() < b.x(); });
      if (left->x() < 0.0 || right->x() > 0.0) continue;  // an arm
      const double girth = loop.girth(m_.up);
      if (girth > best.girth) best = {girth, tape(hull, *right, *left)};
    }
    return best;
  }

  void trunk() {
    const double waist = height(m_.waist.middle), seat = height(m_.hips.middle);
    const double neck = 0.5 * (height(m_.neck_side[0]) + height(m_.neck_side[1]));
    const double hips = waist - 0.45 * (waist - seat);
    add("hpsToBust", down(true, height(m_.bust.middle), neck));
    add("hpsToWaistBack", down(false, waist, neck));
    add("waistToArmpit", 0.5 * (height(m_.armpit[0]) + height(m_.armpit[1])) - waist);
    add("waistToHips", waist - hips);
    add("hips", round(hips).girth);
    add("waistBack", round(waist).back);
    add("seatBack", round(seat).back);
    add("waistToSeat", waist - seat);
    // From the waist in front between the legs to the waist behind.
    const std::vector<Point> points =
        section(m_.left, m_.left.dot(m_.waist.middle), m_.forward, height(m_.crotch) - 0.05, waist);
    const std::vector<Point> hull = detail::hull_around(points);
    const auto lowest = *std::min_element(
        hull.begin(), hull.end(), [](const Point& a, const Point& b) { return a.y() < b.y(); });
    // The ends of the tape, of the points at the height of the waist.
    Point front(-1e300, 0.0), back(1e300, 0.0);
    for (const Point& p : hull) {
      if (p.y() < waist - 0.02) continue;
      if (p.x() > front.x()) front = p;
      if (p.x() < back.x()) back = p;
    }
    add("crossSeam", tape(hull, back, front));
    add("crossSeamFront", tape(hull, lowest, front));
  }

  void legs() {
    double floor = 1e300;
    for (const Vec3& x : body_.vertices) floor = std::min(floor, height(x));
    const double waist = height(m_.waist.middle);
    double knee = 0.0, girth = 0.0;
    for (const BodyLimb& leg : m_.legs) {
      // Half way from the crotch to the ankle.
      const double half = 0.5 * (height(leg.rings.front().middle) + height(leg.lower.middle));
      const auto ring = std::find_if(leg.rings.begin(), leg.rings.end() - 1,
                                     [&](const BodyRing& r) { return height(r.middle) <= half; });
      knee += 0.5 * height(ring->middle);
      girth += 0.5 * ring->girth;
    }
    add("knee", girth);
    add("waistToFloor", waist - floor);
    add("waistToKnee", waist - knee);
    add("waistToUpperLeg", waist - height(m_.crotch));
  }

  TriangleMesh body_;
  const BodyLandmarks& m_;
  std::vector<BodyMeasure> measures_;
};

}  // namespace

std::vector<BodyMeasure> body_measures(const TriangleMesh& body, const BodyLandmarks& landmarks) {
  return Tailor(body, landmarks).measure();
}

}  // namespace selvedge
