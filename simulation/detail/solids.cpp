// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/simulation/detail/solids.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace selvedge::detail {
namespace {

// As in turning_bodies.cpp.
constexpr double kArcShare = 0.25;

// rad/s, from the speeds of the leaders about their mean; with the moments of inertia of a thin
// body at most a factor below the true one.
double turning_rate(const BuiltSolid& solid, const SimulationState& state) {
  Vec3 x = Vec3::Zero(), v = Vec3::Zero();
  for (std::int32_t k = solid.leader; k < solid.leader + solid.leaders; ++k) {
    x += state.x[k] / solid.leaders;
    v += state.v[k] / solid.leaders;
  }
  double turned = 0.0, arm = 0.0;
  for (std::int32_t k = solid.leader; k < solid.leader + solid.leaders; ++k) {
    turned += (state.v[k] - v).squaredNorm();
    arm += (state.x[k] - x).squaredNorm();
  }
  return arm > 0.0 ? std::sqrt(turned / arm) : 0.0;
}

// Radians; a stop farther away is out of reach of a step.
constexpr double kReach = std::numbers::pi / 2.0;
// rad/s, of a stop that gives way.
constexpr double kStopFrequency = 12000.0;
// m, by which a body may end beyond a limit without another solve.
constexpr double kBeyond = 1e-9;
// A stop that has changed so often in a step stays where it pushes: rounding may decide whether one
// without a load does.
constexpr int kMostChanges = 6;

}  // namespace

double longest_turn(const Scene& scene, const BuiltScene& built, const SimulationState& state,
                    double h) {
  for (const BuiltSolid& solid : built.solids) {
    if (solid_of(scene.cloths[solid.piece])->slides()) continue;
    const double rate = turning_rate(solid, state);
    // r (ωh)²/8 <= deviation
    if (rate > 0.0 && solid.radius > 0.0)
      h = std::min(h, std::sqrt(8.0 * kArcShare * scene.contact.rest_gap / solid.radius) / rate);
  }
  return h;
}

std::vector<std::int32_t> solid_of_particles(const BuiltScene& built) {
  std::vector<std::int32_t> of;
  if (built.solids.empty()) return of;
  of.assign(built.cloth.surface.vertices.size(), -1);
  for (std::size_t s = 0; s < built.solids.size(); ++s) {
    const BuiltSolid& solid = built.solids[s];
    for (std::int32_t i = built.piece_begin[solid.piece]; i < solid.leader + solid.leaders; ++i)
      of[i] = static_cast<std::int32_t>(s);
  }
  return of;
}

JointStops::JointStops(const Scene& scene, const BuiltScene& built) {
  for (const BuiltSolid& solid : built.solids) {
    const SolidSpec& spec = *solid_of(scene.cloths[solid.piece]);
    if (!spec.has_limits()) continue;
    Joint joint{};
    joint.leader = solid.leader;
    joint.weight = solid.limited.weight;
    joint.stiffness = solid.mass * kStopFrequency * kStopFrequency;
    joint.origin = solid.limited.start;
    joint.axis = spec.slide.normalized();
    double unit = 1.0;
    if (spec.turns()) {
      joint.origin = 0.5 * (solid.pins[0].start + solid.pins[1].start);
      joint.axis = (spec.hinge[1] - spec.hinge[0]).normalized();
      joint.start = (solid.limited.start - joint.origin) / solid.lever;
      unit = std::numbers::pi / 180.0;
    }
    joint.low = unit * spec.limits[0];
    joint.high = unit * spec.limits[1];
    joints_.push_back(joint);
  }
}

double JointStops::gap_at_end(const Stop& stop, std::span<const Vec3> v_mean) const {
  double gap = stop.gap;
  for (int k = 0; k < 4; ++k)
    gap += h_ * stop.joint->weight[k] * stop.normal.dot(v_mean[stop.joint->leader + k]);
  return gap;
}

void JointStops::begin(std::span<const Vec3> x, std::span<const Vec3> v_mean, double h) {
  h_ = h;
  stops_.clear();
  for (const Joint& joint : joints_) {
    Vec3 way = -joint.origin;
    for (int k = 0; k < 4; ++k) way += joint.weight[k] * x[joint.leader + k];
    const auto add = [&](const Vec3& normal, double gap) {
      stops_.push_back({.joint = &joint, .normal = normal, .gap = gap});
    };
    if (joint.start.isZero(0.0)) {
      add(joint.axis, joint.axis.dot(way) - joint.low);
      add(-joint.axis, joint.high - joint.axis.dot(way));
      continue;
    }
    // The angle is unique about the middle of the limits.
    const Vec3 side = joint.axis.cross(joint.start);
    const double middle = 0.5 * (joint.low + joint.high), half = 0.5 * (joint.high - joint.low);
    const auto [sine, cosine] = elementary::sin_cos(middle);
    const double past = elementary::atan2(way.dot(cosine * side - sine * joint.start),
                                          way.dot(cosine * joint.start + sine * side));
    for (const double sign : {1.0, -1.0}) {  // at the low limit the body turns back up
      if (half + sign * past > kReach) continue;
      const auto limit = elementary::sin_cos(middle - sign * half);
      const Vec3 normal = sign * (limit.cosine * side - limit.sine * joint.start);
      add(normal, normal.dot(way));
    }
  }
  for (Stop& stop : stops_) stop.pushes = gap_at_end(stop, v_mean) < 0.0;
}

std::span<const ImplicitTerm> JointStops::with(std::span<const ImplicitTerm> terms) {
  if (std::ranges::none_of(stops_, &Stop::pushes)) return terms;
  terms_.assign(terms.begin(), terms.end());
  for (const Stop& stop : stops_) {
    if (!stop.pushes) continue;
    const std::int32_t leader = stop.joint->leader;
    // h K times the way beyond the limit at the end of the step
    terms_.push_back(
        {.particle = {leader, leader + 1, leader + 2, leader + 3},
         .weight = stop.joint->weight,
         .matrix = h_ * h_ * stop.joint->stiffness * stop.normal * stop.normal.transpose(),
         .rhs = -h_ * stop.joint->stiffness * stop.gap * stop.normal});
  }
  return terms_;
}

bool JointStops::update(std::span<const Vec3> v_mean) {
  bool changed = false;
  for (Stop& stop : stops_) {
    const double gap = gap_at_end(stop, v_mean);
    const bool pushes = stop.pushes ? gap <= 0.0 : gap < -kBeyond;
    if (pushes == stop.pushes || (!pushes && stop.changes >= kMostChanges)) continue;
    stop.pushes = pushes;
    ++stop.changes;
    changed = true;
  }
  return changed;
}

}  // namespace selvedge::detail
