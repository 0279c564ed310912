// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/simulation.h>

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace selvedge {

/// How one run of one cell ended.
///   ok        came to its end
///   unstable  the state is not finite or stretched beyond all measure
///   failed    a step could not be made clean, or the run stalled
///   refused   the scene cannot start (impossible pair, crossing start)
///   budget    ran out of its time
///   crashed   the process died
enum class RunStatus { ok, unstable, failed, refused, budget, crashed };
const char* status_word(RunStatus status);
/// Throws std::invalid_argument for a word that is none.
RunStatus status_of(const std::string& word);

/// What detectors of a cell were found to report, against exact sets of pairs.
struct PairJudgement {
  std::size_t motions = 0;    ///< steps that were judged
  std::size_t colliding = 0;  ///< pairs that collide in them, by ccd_exact
  std::size_t broad_missed = 0, narrow_missed = 0, narrow_false = 0;
  double recall = 1.0;  ///< of broad and narrow phase together: the share of colliding pairs found
  /// A method that claims to miss nothing missed, or broke another promise; empty: none.
  std::string failure;
};

/// One run of one cell. Times are wall time without any input or output.
struct CellRun {
  RunStatus status = RunStatus::ok;
  std::string why;       ///< in a sentence, where it is not ok
  double build_s = 0.0;  ///< reading meshes, making the simulation
  double run_s = 0.0;    ///< all steps, without the check of frames
  /// Beside these: "reading" the scene, "warming_up", "checking" frames, "judging" detectors,
  /// "writing" start and end; s.
  std::map<std::string, double> beside_s;
  double end_s = 0.0;  ///< simulated, s
  double dt = 0.0;     ///< nominal step, s
  std::size_t particles = 0, peak_bytes = 0;
  RunResult result;
  PairJudgement pairs;  ///< of the first repeat alone
};

struct CellLimits {
  int threads = 1;          ///< 0: all
  double budget_s = 300.0;  ///< of wall time for a run, > 0
  /// Of the first repeat: how many motions detectors are judged on, evenly over the run.
  int judged_motions = 4;
};

/// Runs the scene in `folder`/scene.json once and keeps what came of it in run_`repeat`.json there;
/// of repeat 0 also start and end as frames of a result folder. A step of another simulation goes
/// before it, so that pages, caches and threads are warm. Never throws for what the scene does;
/// throws std::runtime_error for a file that cannot be written.
CellRun run_cell(const std::filesystem::path& folder, int repeat, const CellLimits& limits,
                 const Methods& methods);

/// What run_cell or note_crash kept; none if the run was not made or its file is not whole.
std::optional<CellRun> read_cell_run(const std::filesystem::path& folder, int repeat);

/// Keeps that a run of a cell ended without a word of its own.
void note_run(const std::filesystem::path& folder, int repeat, const CellRun& run);

/// Number of the frame in which run_cell keeps the end; the start is frame 0.
inline constexpr int kEndFrame = 1;

}  // namespace selvedge
