// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/simulation/simulation.h>

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

namespace selvedge {

/// One run of a scene of data/extreme. The exact checker, which shares no code with the simulator,
/// judges every frame and every path between two accepted states.
struct ExtremeRun {
  Scene scene;
  std::string refused;                ///< why the run did not start; "" if it did
  std::string stopped;                ///< why the run stopped; "" if it finished
  std::vector<std::string> warnings;  ///< of the meshes
  RunResult result;
  ClothMesh cloth;  ///< at the start
  std::vector<std::int32_t> piece_begin;
  std::vector<double> times;                      ///< s, of the frames, the start included
  std::vector<std::vector<Vec3>> frames, bodies;  ///< m
  std::vector<Vec3> x, v;                         ///< at the end
  double time = 0.0;                              ///< s, at the end
  bool finite = true;                             ///< every position and velocity is finite
  std::size_t intersections = 0;                  ///< worst frame; self, body and inside
  std::size_t path_collisions = 0;                ///< sum over all paths
  double worst_speed = 0.0;                       ///< m/s, in any accepted state
  double rms_speed = 0.0;                         ///< m/s, at the end
  /// Largest mechanical energy over that at the start; the lowest position of the run is the zero
  /// level. NaN if external motion drives the cloth or nothing ran. Excludes bending energy.
  double energy_ratio = std::numeric_limits<double>::quiet_NaN();

  /// Vertices of a piece in a frame.
  std::span<const Vec3> piece(std::size_t frame, std::size_t piece) const;
};

struct ExtremeConfig {
  std::vector<Override> overrides;
  std::string response;  ///< "": the default
  bool judge_paths = true;
  std::filesystem::path out;  ///< folder of the frames for pictures; "": none
  double wall_limit = 600.0;  ///< s; the run stops after this time and reports it
};

/// Reads a scene file and runs it. Errors of a scene never throw.
ExtremeRun run_extreme(const std::filesystem::path& file, const ExtremeConfig& config);
/// The same for a scene made in code.
ExtremeRun run_extreme(const Scene& scene, const ExtremeConfig& config);

}  // namespace selvedge
