// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/methods.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace selvedge {

/// One parameter that a comparison varies.
struct CompareAxis {
  /// The name that the user wrote: a short name (see short_axes) or a path of the scene file.
  std::string name;
  std::vector<std::string> values;  ///< in the form that `--set` accepts; no duplicates
  bool numeric = false;             ///< all values are numbers, so the plot joins them by a line
};

/// Short names of --vary and the scene keys that they stand for. "mesh", "dt" and "threads"
/// correspond to no single key.
std::vector<std::pair<std::string, std::string>> short_axes();

/// Parses the arguments of --vary. Each has one of the forms "NAME=a,b,c", "NAME=lo..hi:n"
/// (followed by "log" for equal ratios), "NAME=all", or "NAME,NAME,..." for all values of each.
/// Throws std::invalid_argument for an unknown name (and suggests the nearest one), for an empty or
/// malformed list, and for "all" of a key without a list of values.
std::vector<CompareAxis> read_axes(const std::vector<std::string>& vary, const Methods& methods);

/// The full product, or the first value of each axis with one axis varied at a time.
enum class CompareDesign { product, one_at_a_time };

/// The values of each cell, in the order of the axes; the last axis changes fastest. Throws
/// std::invalid_argument if there are more than ten thousand cells.
std::vector<std::vector<std::string>> design_cells(const std::vector<CompareAxis>& axes,
                                                   CompareDesign design);

/// The overrides that a cell applies to the scene. Throws std::invalid_argument if a value of "dt",
/// "mesh" or "threads" is not valid.
std::vector<Override> cell_overrides(const std::vector<CompareAxis>& axes,
                                     const std::vector<std::string>& values, const Scene& base);

/// Value of the named axis in a cell; "" if there is no such axis.
std::string axis_value(const std::vector<CompareAxis>& axes, const std::vector<std::string>& values,
                       const std::string& name);

/// Overrides that set the step length to dt seconds, or slightly less so that a whole number of
/// steps fills the scene's duration. They change the frames only if a step is longer than a frame.
std::vector<Override> step_overrides(const Scene& base, double dt);

/// Length of a nominal step, s.
double nominal_step(const Scene& scene);

/// Replaces the values of the axis "dt" by the steps that step_overrides makes of them, each once.
/// Returns a sentence for each value that changes or is dropped.
std::vector<std::string> round_steps(CompareAxis& dt, const Scene& base);

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
  /// s; all steps, without the check of frames: of the processor for a run of one thread, which a
  /// busy machine does not lengthen; else by the clock.
  double run_s = 0.0;
  double clock_s = 0.0;  ///< s; the same by the clock
  /// Further times in s: "reading" the scene, "warming_up", "checking" frames, "judging" detectors,
  /// "writing" start and end.
  std::map<std::string, double> beside_s;
  double end_s = 0.0;  ///< simulated time, s
  double dt = 0.0;     ///< nominal step, s
  std::size_t particles = 0, peak_bytes = 0;
  RunResult result;
  PairJudgement pairs;  ///< of the first repeat only
};

/// Speed of the perturbation by which the seeds of one scene differ if the scene gives none, m/s: a
/// thousandth of the speeds that cloth reaches.
inline constexpr double kSeedSpeed = 1e-3;

/// Most threads of a run, and most runs of a cell.
inline constexpr int kMaxThreads = 1024, kMaxRepeats = 1000;

struct CellLimits {
  int threads = 1;          ///< 0: all cores
  double budget_s = 300.0;  ///< wall time of a run, > 0
  /// Number of motions of the first repeat on which detectors are checked, spread evenly over the
  /// run.
  int judged_motions = 4;
  /// The repeats are members of an ensemble: repeat r starts with the perturbation of seed r + 1.
  bool seeds = false;
  int core = -1;  ///< processor core that every run is pinned to (Linux only); -1: any
};

/// Runs the scene in `folder`/scene.json once and writes the outcome to run_`repeat`.json there.
/// Repeat 0 also writes start and end as frames of a result folder, and with seeds every other
/// repeat r its end as frame kEndFrame + r. A step of a separate simulation
/// runs first to warm pages, caches and threads. Errors of the scene never throw; throws
/// std::runtime_error if a file cannot be written.
CellRun run_cell(const std::filesystem::path& folder, int repeat, const CellLimits& limits,
                 const Methods& methods);

/// Reads the file that run_cell or note_run wrote. Empty if the run does not exist or its file is
/// incomplete, damaged or from another version.
std::optional<CellRun> read_cell_run(const std::filesystem::path& folder, int repeat);

/// The cloth of one run at its start and at its end.
struct ClothEnds {
  std::vector<Vec3> start, end;  ///< m
  std::vector<Triangle> triangles;
  double extent() const;  ///< m; diagonal of the bounding box at the start
};

/// Empty if the run wrote no end frame. Only with seeds do repeats other than 0 write one.
std::optional<ClothEnds> read_ends(const std::filesystem::path& cell, int repeat = 0);

/// Records that the run of a cell ended without writing an outcome.
void note_run(const std::filesystem::path& folder, int repeat, const CellRun& run);

/// Number of the frame that holds the end in run_cell's output; the start is frame 0.
inline constexpr int kEndFrame = 1;

/// One cell of a comparison: the scene with its values.
struct CompareCell {
  std::string id;                   ///< of its folder: position and hash of its scene
  std::vector<std::string> values;  ///< one per axis
  std::vector<std::string> set;     ///< changes to the scene file: "path=value"
  int threads = 1;
  std::string impossible;  ///< why it cannot run, determined before any run; empty if it can
};

/// Kind of reference for errors.
enum class ReferenceKind {
  none,
  closed_form,  ///< the closed form that the scene names
  converged     ///< three runs with ever finer steps (and meshes, if these are varied)
};

/// The complete plan of a comparison, fixed before it starts and unchanged when a comparison
/// continues.
struct ComparePlan {
  std::string name, command;
  std::filesystem::path scene;
  std::vector<CompareAxis> axes;
  std::vector<CompareCell> cells;
  std::vector<std::string> levels;  ///< folders of the reference runs, coarse to fine
  ReferenceKind reference = ReferenceKind::none;
  std::string error = "position";  ///< the quantity of errors (detail/compare_error.h)
  CellLimits limits;
  int repeats = 7;    ///< of a cell; with limits.seeds, also of a reference level
  std::string build;  ///< of the program; times and bits of different builds must not be mixed
};

/// The limits of the plan for a run of one cell or reference level. Reference levels do not judge
/// their detectors.
CellLimits limits_of(const ComparePlan& plan, const std::string& id);

/// The folder of one cell or reference level.
std::filesystem::path cell_folder(const std::filesystem::path& out, const std::string& id);

/// Writes plan.json and the scenes of all cells. Throws std::invalid_argument if the folder holds
/// another comparison or other files.
void write_plan(const std::filesystem::path& out, const ComparePlan& plan,
                const std::vector<std::pair<std::string, std::string>>& scene_of_id);
/// Throws std::invalid_argument if the plan is missing or damaged, with the place of a value that a
/// plan cannot have.
ComparePlan read_plan(const std::filesystem::path& out);

/// Runs one repeat of one cell in a copy of this process, so that a crash or an endless loop
/// affects no other run. Records an outcome if the run wrote none. Throws std::runtime_error if no
/// process can be started or nothing can be written, and std::logic_error if this process has a
/// second thread.
void run_in_process(const std::filesystem::path& out, const std::string& id, int repeat,
                    const CellLimits& limits, const Methods& methods);

/// Times of the runs that wrote an outcome themselves.
struct TimeOfRuns {
  int runs = 0;
  double run_s = 0.0;  ///< building, steps and checks of frames, as in any run
  std::map<std::string, double>
      beside_s;  ///< additional work of the comparison (CellRun::beside_s)
};

/// Number of runs of a reference level, and of all cells and levels.
int level_runs(const ComparePlan& plan);
int run_count(const ComparePlan& plan);

/// Executes all missing runs: references first, then all cells in rounds, so that a disturbance of
/// the machine affects all of them. A cell whose run was not ok is not repeated. `progress`
/// receives the number of finished runs and of all runs. Returns the time of the new runs.
TimeOfRuns run_missing(const std::filesystem::path& out, const ComparePlan& plan,
                       const Methods& methods,
                       const std::function<void(int done, int all)>& progress);

/// FNV-1a hash in 16 hex digits.
std::string text_hash(const std::string& text);
/// The same hash of this program's file, combined with its version; "" if the system does not
/// provide the path.
std::string program_hash();

/// Names of the quantities in which a comparison can measure errors.
std::vector<std::string> error_names();

/// The user's request for a comparison.
struct CompareRequest {
  std::filesystem::path scene;
  std::vector<Override> set;            ///< for all cells and the reference
  std::vector<Override> reference_set;  ///< for the reference only
  std::vector<std::string> vary;
  CompareDesign design = CompareDesign::product;
  bool reference = true;           ///< if there is a parameter to refine and a value to compare
  std::string error = "position";  ///< a name of error_names()
  int repeats = 7;                 ///< with limits.seeds: members of each ensemble
  CellLimits limits;
  std::string command;
};

/// A plan and the scenes of all its cells and reference levels, by folder name.
struct PlannedCompare {
  ComparePlan plan;
  std::vector<std::pair<std::string, std::string>> scene_of_id;
};

/// Reads the scene and the axes and checks whether every cell can start. Cells that cannot start
/// are marked, skipped and reported to `note`, as are steps that had to be rounded. Throws
/// std::invalid_argument for an error that concerns all cells.
PlannedCompare plan_compare(const CompareRequest& request, const Methods& methods,
                            const std::function<void(const std::string&)>& note);

/// Writes a Snakefile [Molder2021] beside the plan, with one job per cell and one job that makes
/// the table and the page. Jobs may run on any machines that share the folder and have the same
/// build.
void write_workflow(const std::filesystem::path& out, const ComparePlan& plan);

}  // namespace selvedge
