// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/build.h>
#include <selvedge/simulation/simulation_state.h>

namespace selvedge::detail {

/// The longest step, s, at most h, in which no rigid body of the pieces turns so far that its
/// vertices on their straight paths leave their arcs by more than a share of the rest gap.
double longest_turn(const Scene& scene, const BuiltScene& built, const SimulationState& state,
                    double h);

/// The number of the rigid body of each particle; -1: none. Empty: there are none.
std::vector<std::int32_t> solid_of_particles(const BuiltScene& built);

}  // namespace selvedge::detail
