// SPDX-License-Identifier: MIT
//
// Whether the forces on the cloth are in balance.
#pragma once

#include <selvedge/core/cloth/followers.h>
#include <selvedge/core/solver/strain_limiter.h>
#include <selvedge/simulation/step_report.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// The forces on the cloth at a state, all arrays of all particles.
struct ForcesAtRest {
  std::span<const Vec3> force;           ///< N, of all but contacts, without motion
  std::span<const double> mass;          ///< kg
  std::span<const double> inv_mass;      ///< 1/kg, 0: held
  std::span<const StepContact> near;     ///< with their gaps at that state
  std::span<const HeldStrain> held{};    ///< strains that the limiter holds
  double step = 1.0;                     ///< s, in which the impulses of `near` acted
  const Followers* followers = nullptr;  ///< null: no particle follows others
};

/// The force that neither contacts nor the strain limiter can balance, by the weight of the cloth
/// (at 9.81 m/s²): the root mean square over the free particles of |force| / weight, each counted
/// by its mass. A contact within its rest gap can take any force in its friction cone, a strain at
/// its limit any that holds it there. From those of the step, sweeps over both look for the forces
/// that leave least; every force they try is possible, so the result is an upper bound. The sweeps
/// end where it is below `enough`. 0 without free particles.
double unbalanced_share(const ForcesAtRest& forces, double enough);

}  // namespace selvedge::detail
