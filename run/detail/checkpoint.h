// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/base/internal/json_value.h>
#include <selvedge/run/frame_writer.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

using Json = nlohmann::json;
using Value = JsonValue<Json>;

/// The point from which a run can be resumed.
struct Checkpoint {
  int frame = 0;  ///< last one written
  SimulationState state;
  RunResult result;  ///< of the run so far; only the fields that a checkpoint keeps
};

/// The pieces and bodies of a simulation, for files that keep them apart.
struct FrameParts {
  std::vector<FramePart> pieces, bodies;
  std::vector<std::array<TexturePoint, 3>> texture;  ///< see Frame::texture
};

/// A state of a run as its files hold it. It is a copy, so that a task can write it while the
/// simulation goes on.
struct StateCopy {
  int number = 0;     ///< of the frame or step
  double time = 0.0;  ///< s, as the frame writers get it
  SimulationState state;
  std::vector<std::uint8_t> flags;
  std::vector<double> pressure;                         ///< Pa per vertex; empty: not wanted
  std::vector<Vec3> bodies;                             ///< m; empty if the bodies are not due
  std::span<const Triangle> triangles, body_triangles;  ///< of `owner`
  std::vector<NamedWrench> wrenches;                    ///< empty: not wanted
  std::shared_ptr<const void> owner;
  std::shared_ptr<const FrameParts> parts{};  ///< null: no format needs them
};

/// Writes checkpoint.ply and checkpoint.json into the result folder `out`. `result`: of the run up
/// to that state, with its hash.
void write_checkpoint(const std::filesystem::path& out, int frame, const StateCopy& copy,
                      const RunResult& result);
/// Throws std::invalid_argument with file, fault and remedy if there is no checkpoint or it is
/// damaged.
Checkpoint read_checkpoint(const std::filesystem::path& out);

/// Per-vertex values of a frame file: those of state_values; flag; side while there are tangles (0:
/// in none; else odd on the first side of a tangle and even on the second); and pressure (Pa) if it
/// is wanted.
std::vector<NamedValues> frame_values(const StateCopy& copy);
/// Per-vertex values of a state file: velocities vx, vy, vz (m/s), and water (kg) if there is any.
std::vector<NamedValues> state_values(const SimulationState& state);
/// Velocities from the values of a file. Throws std::invalid_argument that names `file` if they are
/// missing.
std::vector<Vec3> velocities(const std::vector<NamedValues>& values,
                             const std::filesystem::path& file);

/// Positions, velocities and water of a frame or checkpoint file; nullopt if the file is missing,
/// damaged or holds a state with another hash.
std::optional<SimulationState> read_state(const std::filesystem::path& file,
                                          const std::string& hash);

/// Writes the parts of a state that no PLY file holds into a JSON object: time, step, control,
/// tangles, memory, splits and merges, and whether they are made.
void write_state_fields(const SimulationState& state, Json& json);
/// Reads them. Only time and step are required, because older checkpoints have only these. Throws
/// JsonFault for a wrong type and std::invalid_argument for damaged memory.
void read_state_fields(const Value& json, SimulationState& state);

/// Memory of integrator and forces: 16 hexadecimal digits for the bits of each number.
std::string memory_text(std::span<const double> memory);
/// Throws std::invalid_argument for any other text.
std::vector<double> memory_from(const std::string& text);

}  // namespace selvedge::detail
