// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/simulation.h>

#include <filesystem>
#include <string>
#include <vector>

namespace selvedge {

/// A run that stopped, as it is kept in a folder of its own (RESULT/failure):
///   failure.json            what stopped the run, when, after which tries, which pairs; written
///   last cause.txt               the cause in one line state.ply               the last good
///   state: positions and velocities, to the bit scene.json, meshes/     the scene as run, with the
///   meshes that it reads (up to 64 MB of them) frames/cloth_00000.ply, frames/cloth_00001.ply,
///   frames/bodies_0000?.ply
///                           the triangles, edges and points that collide, with the triangles at
///                           them, at the start and at the end of the last try: a small result of
///                           two frames, which `selvedge render` draws
///   queries/point_triangle.csv, queries/edge_edge.csv
///                           the colliding pairs and the candidates around them as queries of
///                           `selvedge ccd`, with their true answers
/// What a failure does not have (a run out of budget collides with nothing) is left out.
struct FailureBundle {
  std::filesystem::path folder;
  bool scene_from_file = true;  ///< else made in code, and scene.json holds no more than its name
  FailureKind kind = FailureKind::not_clean;
  std::string cause;          ///< one line
  SimulationState state;      ///< the last good one
  std::string bodies_hash;    ///< of the body vertices at its time, as state_hash
  std::vector<double> tried;  ///< s, lengths of the tries
};

/// Keeps the state of `simulation` and its last failed try. Replaces a bundle that is there. Throws
/// std::runtime_error with file and cause where a file cannot be written.
void write_failure_bundle(const std::filesystem::path& folder, const Scene& scene,
                          const Simulation& simulation, const SimulationFailed& failure);

/// Throws std::invalid_argument with file, fault and remedy for a bundle that is damaged or none.
FailureBundle read_failure_bundle(const std::filesystem::path& folder);

/// Removes the files of a bundle, and nothing else.
void remove_failure_bundle(const std::filesystem::path& folder);

}  // namespace selvedge
