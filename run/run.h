// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/run/frame_writer.h>
#include <selvedge/scene/methods.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>

namespace selvedge {

struct RunConfig {
  std::filesystem::path out;                      ///< result folder, made if missing
  Methods methods;                                ///< methods that the scene may name
  FrameFormatRegistry formats = frame_formats();  ///< formats that `output` of the scene may name
  bool resume = false;                            ///< continue from the checkpoint in the folder
  bool overwrite = true;  ///< without `resume`: replace the results of an earlier run in the folder
  bool every_step = false;  ///< also write every accepted state to steps/
  /// Wall seconds after which the run stops at the end of the current step.
  double budget_s = std::numeric_limits<double>::infinity();
  int max_steps = 0;  ///< largest number of accepted steps in this call; 0: unlimited
  /// A run is stalled when this many accepted steps in a row are near the smallest step length
  /// (is_near_smallest): with 8 halvings, more than a hundred steps for each planned one. 0: never.
  int stall_steps = 512;
  /// When it becomes true, the run ends after the current frame. May be null.
  const std::atomic<bool>* stop = nullptr;
  /// Called for every frame, once its files are whole, with its number and the seconds since the
  /// start of the run; by then the next steps may have been made. Called by the thread of the run.
  std::function<void(int frame, double seconds)> progress;
  /// Called with one sentence per possible mistake, e.g. a body that is not closed.
  std::function<void(const std::string& sentence)> warning;
};

/// Runs a scene into a result folder (layout: result_folder.h). Every frame and the checkpoint are
/// written when the frame is complete. With several threads, a thread of its own writes them while
/// the next frame is computed. A stopped run loses at most the current frame, a killed run also the
/// one that is being written, and a resumed run gives the same bits as an uninterrupted one.
///
/// Frame writers (RunConfig::formats) run in that thread, one frame after the other.
///
/// Throws std::invalid_argument for a scene that cannot start, for an unknown format, for a folder
/// that cannot be made, holds something else (results of another scene, other files) or is in use
/// by another run (core/system/internal/files.h), and for a resume that does not fit. A run that
/// fails later writes result.json with `stopped` set if it can, and throws SimulationFailed, or
/// std::runtime_error for a file that could not be written.
///
/// Without `resume`, the run replaces an earlier run of the same scene in the folder, but only
/// after the new one has proved able to start; it removes all files that the earlier run, `measure`
/// and pictures of frames have left. Without `overwrite` it refuses such a folder.
RunResult run_scene(const Scene& scene, const RunConfig& config);

}  // namespace selvedge
