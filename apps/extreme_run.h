// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/simulation.h>

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

namespace selvedge {

/// One run of a scene of data/extreme, judged by the exact check that shares no code with the
/// simulator: every frame, and every path between two accepted states.
struct ExtremeRun {
  Scene scene;
  std::string refused;                ///< "" or why it did not start
  std::string stopped;                ///< "" or why it did not go on
  std::vector<std::string> warnings;  ///< of the meshes
  RunResult result;
  ClothMesh cloth;  ///< at the start
  std::vector<std::int32_t> piece_begin;
  std::vector<double> times;                      ///< s, of the frames, the start included
  std::vector<std::vector<Vec3>> frames, bodies;  ///< m
  std::vector<Vec3> x, v;                         ///< in the end
  double time = 0.0;                              ///< s, in the end
  bool finite = true;                             ///< every position and velocity
  std::size_t intersections = 0;                  ///< worst frame: self, body, inside
  std::size_t path_collisions = 0;                ///< sum over the paths
  double worst_speed = 0.0;                       ///< m/s, in any accepted state
  double rms_speed = 0.0;                         ///< m/s, in the end
  /// Largest mechanical energy over that at the start, the lowest position of the run as zero; not
  /// a number where something from outside moves the cloth, or nothing ran. Bending is left out.
  double energy_ratio = std::numeric_limits<double>::quiet_NaN();

  /// Vertices of a piece in a frame.
  std::span<const Vec3> piece(std::size_t frame, std::size_t piece) const;
};

struct ExtremeConfig {
  std::vector<Override> overrides;
  std::string response;  ///< "": the default
  bool judge_paths = true;
  std::filesystem::path out;  ///< frames are written here for pictures; "": nowhere
  double wall_limit = 600.0;  ///< s, after which the run is stopped and says so
};

/// Reads a scene file and runs it. Throws nothing that a scene can cause.
ExtremeRun run_extreme(const std::filesystem::path& file, const ExtremeConfig& config);
/// The same for a scene made in code.
ExtremeRun run_extreme(const Scene& scene, const ExtremeConfig& config);

}  // namespace selvedge
