// SPDX-License-Identifier: MIT
//
// Cloth at rest that leaves out its steps.
#pragma once

#include <selvedge/scene/build.h>
#include <selvedge/simulation/simulation_state.h>

#include <span>

namespace selvedge::detail {

/// Puts the cloth of a scene to sleep (`time.sleep_speed`), as rigid-body engines do: once no
/// particle was faster than this speed for half a second, the velocities are set to zero and steps
/// are left out until something acts on the cloth.
class Sleep {
 public:
  /// Cloth with water, and cloth in air that changes with time, never sleeps.
  Sleep(const Scene& scene, const BuiltScene& built);

  /// For how long no particle has been faster, s: at the end of a step of `h` s with velocities
  /// `v`, if it was `still` at its begin.
  double still_after(double still, std::span<const Vec3> v, double h) const;

  /// Whether the cloth has been still for long enough to sleep.
  bool is_due(const SimulationState& state) const;
  /// Whether it sleeps from `state` to `t1`: it is due, no body moves, and no handle moves or lets
  /// go.
  bool sleeps(const SimulationState& state, double t1) const;

 private:
  bool handle_acts(const SimulationState& state, double t1) const;

  const Scene& scene_;
  const BuiltScene& built_;
  double speed_ = 0.0;  // m/s; 0: never sleeps
};

}  // namespace selvedge::detail
