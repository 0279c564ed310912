// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/simulation/simulation_state.h>

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace selvedge {

/// m, of the vertices of driven bodies, by number.
using BodyPlaces = std::map<std::size_t, std::vector<Vec3>>;

/// A state as one line of text, from which it is read back to the last bit.
std::string state_text(const SimulationState& state, const BodyPlaces& bodies);
/// Throws std::invalid_argument for a text that is damaged.
std::pair<SimulationState, BodyPlaces> state_from_text(const std::string& text);

}  // namespace selvedge
