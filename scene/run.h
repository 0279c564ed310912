// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/simulation.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <limits>

namespace selvedge {

struct RunConfig {
  std::filesystem::path out;  ///< result folder, made if missing
  Methods methods;            ///< what scenes may name
  bool resume = false;        ///< go on from checkpoint.ply in it
  bool every_step = false;    ///< also write every accepted state to steps/
  /// Wall seconds after which the run stops at the end of the step in work.
  double budget_s = std::numeric_limits<double>::infinity();
  int max_steps = 0;  ///< so many accepted steps in this call at most; 0: any number
  /// The run is stalled when so many accepted steps in a row are near the smallest size
  /// (is_near_smallest): with 8 halvings, more than a hundred steps for each planned one. 0: never.
  int stall_steps = 512;
  const std::atomic<bool>* stop =
      nullptr;  ///< when it becomes true the run ends after the frame in work
  /// Called after every frame with its number and the seconds since the start of the run.
  std::function<void(int frame, double seconds)> progress;
  /// Called with one sentence for each thing that may be wrong, e.g. a body that is not closed.
  std::function<void(const std::string& sentence)> warning;
};

/// Runs a scene into a result folder (layout: output.h). Every frame and the checkpoint are written
/// when the frame is done; a stopped or killed run loses at most the frame in work, and resumed
/// goes on to the same bits. Throws std::invalid_argument for a scene that cannot start, for a
/// folder that cannot be made or holds something else (another scene's results, other files), and
/// for a resume that does not fit. A run that fails on its way writes result.json with `stopped`
/// set if it can, and throws SimulationFailed, or std::runtime_error for a file that could not be
/// written. Whoever asks for a run without `resume` in a folder with an earlier run of the same
/// scene replaces it, but only once the new one has been found fit to start.
RunResult run_scene(const Scene& scene, const RunConfig& config);

}  // namespace selvedge
