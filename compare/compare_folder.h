// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/compare/compare_axes.h>
#include <selvedge/compare/compare_cell.h>

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace selvedge {

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
  CellLimits limits;
  int repeats = 7;
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
/// Throws std::invalid_argument if the plan is missing or damaged.
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

}  // namespace selvedge
