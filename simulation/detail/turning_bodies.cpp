// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/simulation/detail/turning_bodies.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace selvedge::detail {
namespace {

// Share of the rest gap by which chords may deviate.
constexpr double kGapShare = 0.25;

// Times nearer than this share of the step are the same. Steps end at multiples of the nominal
// step, which are rounded.
constexpr double kSameTime = 1e-9;

// rad, of the shorter way between two keyframes, which the interpolation takes; and its axis.
struct Angle {
  double angle;
  Vec3 axis;
};

Angle between(const Keyframe& a, const Keyframe& b) {
  const Eigen::Quaterniond q = b.rotation.normalized() * a.rotation.normalized().conjugate();
  const double sine = q.vec().norm();
  return {2.0 * elementary::atan2(sine, std::abs(q.w())),
          sine > 0.0 ? Vec3(q.vec() / sine) : Vec3(Vec3::Zero())};
}

// m, largest distance of a vertex from the axis through the body's origin.
double radius_about(const Vec3& axis, const Vec3& origin, const std::vector<Vec3>& x) {
  double radius = 0.0;
  for (const Vec3& p : x) radius = std::max(radius, (p - origin).cross(axis).norm());
  return radius;
}

double smallest_rest_gap(const Scene& scene, const ContactPairs& pairs, std::size_t body) {
  double gap = scene.contact.rest_gap;
  const std::size_t pieces = scene.cloths.size();
  for (std::size_t piece = 0; piece < pieces; ++piece)
    gap = std::min(gap, pairs.rest_gap(static_cast<std::int32_t>(piece),
                                       static_cast<std::int32_t>(pieces + body)));
  return gap;
}

}  // namespace

bool TurningBodies::Turn::turns() const { return std::isfinite(longest); }

TurningBodies::TurningBodies(const Scene& scene, const BuiltScene& built) {
  const ContactPairs pairs(scene);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const std::vector<Keyframe>& keys = scene.bodies[b].motion;
    if (keys.size() < 2 || !built.bodies[b]->pose(0.0)) continue;
    const double deviation = kGapShare * smallest_rest_gap(scene, pairs, b);
    TurningBody body{b, {}};
    std::vector<Vec3> x(built.bodies[b]->vertex_count());
    for (std::size_t k = 0; k + 1 < keys.size(); ++k) {
      Turn turn{keys[k].time, keys[k + 1].time, std::numeric_limits<double>::infinity()};
      if (const auto [angle, axis] = between(keys[k], keys[k + 1]); angle > 0.0) {
        built.bodies[b]->positions(keys[k].time, x);
        const Vec3 origin = built.bodies[b]->pose(keys[k].time)->translation;
        const double radius = radius_about(axis, origin, x);
        // r (ωh)²/8 <= deviation, the bound of chord_deviation in the room detection.
        if (radius > 0.0)
          turn.longest = std::sqrt(8.0 * deviation / radius) * (turn.end - turn.begin) / angle;
      }
      body.turns.push_back(turn);
    }
    if (std::ranges::any_of(body.turns, [](const Turn& t) { return t.turns(); }))
      bodies_.push_back(std::move(body));
  }
}

double TurningBodies::longest_step(const BuiltScene& built, double time, double h) const {
  for (const TurningBody& body : bodies_)
    if (built.bodies[body.index]->pose(time))  // a program has not replaced it
      h = longest_step(body.turns, time, h);
  return h;
}

double TurningBodies::longest_step(const std::vector<Turn>& turns, double time, double h) {
  const double same = kSameTime * h;
  for (const Turn& turn : turns) {
    if (!turn.turns() || turn.end <= time + same || turn.begin >= time + h - same) continue;
    if (turn.begin > time + same) return turn.begin - time;
    // Where the turn ends, the path has a corner.
    h = std::min(h, turn.longest);
    if (turn.end < time + h - same) h = turn.end - time;
    return h;
  }
  return h;
}

}  // namespace selvedge::detail
