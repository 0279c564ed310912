// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace selvedge {

// -- the step at which a run stopped --------------------------------------------------------------

// clang-format off
/// A run that stopped, as it is kept in RESULT/failure:
///   failure.json             cause, time, attempted step lengths and pairs; written last
///   cause.txt                the cause in one line
///   state.ply                the last good state: positions and velocities, exactly
///   scene.json, meshes/      the scene as run, with copies of its meshes (up to 64 MB together)
///   frames/cloth_00000.ply   the colliding triangles, edges and points with the triangles around
///   frames/cloth_00001.ply   them, at the start and at the end of the last attempt: a small result
///   frames/bodies_0000?.ply  of two frames, which `selvedge render` draws
///   queries/*.csv            the colliding pairs and the candidates around them as queries of
///                            `selvedge ccd`, with their true answers
/// A failure without collisions, such as a run out of budget, has no frames/ and no queries/.
// clang-format on
struct FailureBundle {
  std::filesystem::path folder;
  bool scene_from_file = true;  ///< false: made in code, and scene.json holds only its name
  FailureKind kind = FailureKind::not_clean;
  std::string cause;             ///< one line
  SimulationState state;         ///< the last good one
  std::string bodies_hash;       ///< of the body vertices at its time, as state_hash
  std::vector<double> attempts;  ///< s, step lengths of the attempts
};

/// Throws std::invalid_argument with file, fault and remedy if there is no bundle or it is damaged.
FailureBundle read_failure_bundle(const std::filesystem::path& folder);

/// Outcome of a repeated step.
struct StepReplay {
  std::optional<FailureKind> failure;  ///< nullopt: the step passes now
  std::string cause;                   ///< "" if it passes
  std::vector<double> attempts;        ///< s, step lengths of the attempts, the accepted one too
  std::string state_hash;              ///< of the state afterwards
  bool as_recorded = false;            ///< same failure, same cause, exactly the same attempts
};

/// Restores the state of the bundle in `simulation`, which was made from the scene of the bundle,
/// and repeats the step that failed. A step that was recorded as stalled fails again if it is
/// accepted only near the smallest step length again. Throws std::invalid_argument if state or
/// bodies differ from those of the bundle.
StepReplay replay_step(Simulation& simulation, const Scene& scene, const FailureBundle& bundle);

// -- two runs -------------------------------------------------------------------------------------

/// The first state in which two runs differ.
struct RunDifference {
  bool every_step = false;  ///< steps were compared, else frames
  int compared = 0;         ///< equal states from the start on
  int states_a = 0, states_b = 0;
  bool differ = false;  ///< some state that both runs have differs
  /// Of the first state that differs:
  int number = -1;            ///< of the step or frame
  std::string surface;        ///< "cloth" or "bodies"
  std::int32_t vertex = -1;   ///< first vertex that differs, by its index in the file
  std::int64_t vertices = 0;  ///< number of vertices that differ
  Vec3 x_a, x_b;              ///< m, of the first vertex
  double distance = 0.0;      ///< m, largest between the positions of one vertex
  double speed = 0.0;         ///< m/s, largest between the velocities of one vertex
  std::string structure;  ///< why the vertices do not correspond, e.g. other counts; "" if they do
};

/// Compares the states of two result folders bit by bit in order of time: every accepted step if
/// both have steps/, else the frames. Throws std::invalid_argument for a folder without states and
/// for a damaged file.
RunDifference find_difference(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace selvedge
