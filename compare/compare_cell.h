// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/simulation/simulation.h>

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace selvedge {

/// Status of one run of one cell.
///   ok        the run finished
///   unstable  the state is not finite or springs exceed ten times their length
///   failed    a step could not be made clean, or the run stalled
///   refused   the scene cannot start (unsupported combination, crossing at the start)
///   budget    the run exceeded its time budget
///   crashed   the process died
enum class RunStatus { ok, unstable, failed, refused, budget, crashed };
const char* status_word(RunStatus status);
/// Throws std::invalid_argument for an unknown word.
RunStatus status_of(const std::string& word);

/// Pairs that the detectors of a cell report, compared with exact sets of pairs.
struct PairJudgement {
  std::size_t motions = 0;    ///< steps that were checked
  std::size_t colliding = 0;  ///< pairs that collide in these steps, by ccd_exact
  std::size_t broad_missed = 0, narrow_missed = 0, narrow_false = 0;
  double recall = 1.0;  ///< share of the colliding pairs that broad and narrow phase together find
  /// How a method broke a promise, such as never to miss a collision; empty if none did.
  std::string failure;
};

/// One run of one cell. All times are wall time without input and output.
struct CellRun {
  RunStatus status = RunStatus::ok;
  std::string why;       ///< a sentence, if the status is not ok
  double build_s = 0.0;  ///< s; reading meshes and building the simulation
  double run_s = 0.0;    ///< s; all steps, without the check of frames
  /// Further times in s: "reading" the scene, "warming_up", "checking" frames, "judging" detectors,
  /// "writing" start and end.
  std::map<std::string, double> beside_s;
  double end_s = 0.0;  ///< simulated time, s
  double dt = 0.0;     ///< nominal step, s
  std::size_t particles = 0, peak_bytes = 0;
  RunResult result;
  PairJudgement pairs;  ///< of the first repeat only
};

struct CellLimits {
  int threads = 1;          ///< 0: all cores
  double budget_s = 300.0;  ///< wall time of a run, > 0
  /// Number of motions of the first repeat on which detectors are checked, spread evenly over the
  /// run.
  int judged_motions = 4;
};

/// Runs the scene in `folder`/scene.json once and writes the outcome to run_`repeat`.json there.
/// Repeat 0 also writes start and end as frames of a result folder. A step of a separate simulation
/// runs first to warm pages, caches and threads. Errors of the scene never throw; throws
/// std::runtime_error if a file cannot be written.
CellRun run_cell(const std::filesystem::path& folder, int repeat, const CellLimits& limits,
                 const Methods& methods);

/// Reads the file that run_cell or note_crash wrote. Empty if the run does not exist or its file is
/// incomplete.
std::optional<CellRun> read_cell_run(const std::filesystem::path& folder, int repeat);

/// Records that the run of a cell ended without writing an outcome.
void note_run(const std::filesystem::path& folder, int repeat, const CellRun& run);

/// Number of the frame that holds the end in run_cell's output; the start is frame 0.
inline constexpr int kEndFrame = 1;

}  // namespace selvedge
