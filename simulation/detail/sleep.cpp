// SPDX-License-Identifier: MIT
#include <selvedge/simulation/detail/handles.h>
#include <selvedge/simulation/detail/sleep.h>
#include <selvedge/simulation/detail/step.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

// s. Long enough that a turning point of a swing is no rest: cloth that stays slower than v for
// this time is accelerated by less than 4 v per second.
constexpr double kStill = 0.5;

// Rounding of the position of a handle at rest between two equal keyframes, by its coordinates.
constexpr double kRounding = 1e-14;

}  // namespace

Sleep::Sleep(const Scene& scene, const BuiltScene& built) : scene_(scene), built_(built) {
  const bool changes = scene.water || scene.air.gusts.speed > 0.0;
  if (!changes) speed_ = scene.time.sleep_speed;
}

double Sleep::still_after(double still, std::span<const Vec3> v, double h) const {
  if (!(speed_ > 0.0)) return 0.0;
  const bool is_still =
      std::all_of(v.begin(), v.end(), [&](const Vec3& u) { return u.norm() <= speed_; });
  return is_still ? still + h : 0.0;
}

bool Sleep::is_due(const SimulationState& state) const {
  return speed_ > 0.0 && state.still >= kStill;
}

bool Sleep::sleeps(const SimulationState& state, double t1) const {
  return is_due(state) && !bodies_move(built_, state.time, t1) && !handle_acts(state, t1);
}

bool Sleep::handle_acts(const SimulationState& state, double t1) const {
  // After a release the cloth has to be still for kStill anyway. The step in which it happened may
  // have been twice as long as this one (joined steps).
  const double recent = std::max(kStill, 2.0 * (t1 - state.time));
  for (const HandleSpec& handle : scene_.handles)
    if (handle.release && *handle.release <= state.time && *handle.release > state.time - recent)
      return true;
  bool moves = false;
  visit_held(scene_, built_, state.time, t1, [&](std::int32_t i, const Vec3& end, std::int32_t) {
    if ((end - state.x[i]).norm() > kRounding * end.norm()) moves = true;
  });
  return moves;
}

}  // namespace selvedge::detail
