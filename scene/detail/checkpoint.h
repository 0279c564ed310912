// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/mesh_file.h>
#include <selvedge/scene/simulation.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

using Json = nlohmann::json;

/// What a frame carries beside positions: velocities, and the flags as the property flag.
std::vector<NamedValues> frame_values(const Simulation& simulation);
/// Velocities, m/s, as the vertex properties vx, vy, vz of a PLY file.
std::vector<NamedValues> velocity_values(std::span<const Vec3> v);
/// Velocities, and water where there is any, as the property water (kg).
std::vector<NamedValues> state_values(const SimulationState& state);
/// Velocities read back. Throws std::invalid_argument, naming `file`, where they are missing.
std::vector<Vec3> velocities(const std::vector<NamedValues>& values,
                             const std::filesystem::path& file);

/// Positions and velocities of a frame or checkpoint if they are the ones with this hash.
std::optional<SimulationState> read_state(const std::filesystem::path& file,
                                          const std::string& hash);

/// What a resumed run has to know of what was counted and measured before it.
Json to_json(const RunResult& r);
/// Throws Json::exception where something is missing.
RunResult result_from(const Json& j);
/// Adds what an earlier part of the same run counted and measured.
void carry_on(const RunResult& before, RunResult& r);

Json to_json(const StepControl& control);
/// Throws Json::exception where something is missing.
StepControl control_from(const Json& j);

Json to_json(const Tangles& tangles);
/// Throws Json::exception where something is missing.
Tangles tangles_from(const Json& j);

/// The memory of integrator and forces: 16 hexadecimal digits for the bits of each number.
std::string memory_text(std::span<const double> memory);
/// Throws std::invalid_argument for a text that is none.
std::vector<double> memory_from(const std::string& text);
Json to_json(const std::vector<SplitEvent>& splits);
/// Throws Json::exception where something is missing.
std::vector<SplitEvent> splits_from(const Json& j);

/// What must be the same when a run goes on: everything but its length and what it writes.
Json what_decides(Json scene);

}  // namespace selvedge::detail
