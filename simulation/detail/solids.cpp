// SPDX-License-Identifier: MIT
#include <selvedge/simulation/detail/solids.h>

#include <algorithm>
#include <cmath>

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

}  // namespace selvedge::detail
