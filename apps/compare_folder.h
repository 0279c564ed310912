// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/compare_axes.h>
#include <selvedge/apps/compare_cell.h>

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace selvedge {

/// One cell of a compare: the scene with its values.
struct CompareCell {
  std::string id;                   ///< of its folder: place and hash of its scene
  std::vector<std::string> values;  ///< of the axes
  std::vector<std::string> set;     ///< what makes its scene of the file: "path=value"
  int threads = 1;
  std::string impossible;  ///< why it cannot run, said before anything runs; empty: it can
};

/// What errors are measured against.
enum class ReferenceKind {
  none,
  closed_form,  ///< what the scene names
  converged     ///< three runs with ever finer steps (and meshes, where these are varied)
};

/// All that a compare does, fixed before it starts; the same for whoever goes on with it.
struct ComparePlan {
  std::string name, command;
  std::filesystem::path scene;
  std::vector<CompareAxis> axes;
  std::vector<CompareCell> cells;
  std::vector<std::string> levels;  ///< folders of the reference runs, coarse to fine
  ReferenceKind reference = ReferenceKind::none;
  CellLimits limits;
  int repeats = 7;
  std::string build;  ///< of the program: times and bits of another one do not mix with these
};

/// What the plan grants to a run of one cell or reference level; of the latter nobody asks which
/// pairs its detectors found.
CellLimits limits_of(const ComparePlan& plan, const std::string& id);

/// The folder of one cell or reference level.
std::filesystem::path cell_folder(const std::filesystem::path& out, const std::string& id);

/// Writes plan.json and the scenes of all cells. Refuses, by std::invalid_argument, a folder that
/// holds another compare, or other files.
void write_plan(const std::filesystem::path& out, const ComparePlan& plan,
                const std::vector<std::pair<std::string, std::string>>& scene_of_id);
/// Throws std::invalid_argument if there is none, or it is damaged.
ComparePlan read_plan(const std::filesystem::path& out);

/// Keeps a folder for one compare at a time, as long as it lives; the system lets go of it when the
/// process dies. Throws std::invalid_argument if another one has it.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& out);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_ = -1;
};

/// Runs one repeat of one cell in a copy of this process, so that a crash or a loop takes nothing
/// else with it, and notes what it did not note itself. Throws std::runtime_error if no process can
/// be started or nothing can be written, std::logic_error where this one has a second thread.
void run_in_process(const std::filesystem::path& out, const std::string& id, int repeat,
                    const CellLimits& limits, const Methods& methods);

/// Where the time went of runs that came to a word of their own.
struct TimeOfRuns {
  int runs = 0;
  double run_s = 0.0;  ///< building, steps, check of frames: what anybody's run needs
  std::map<std::string, double> beside_s;  ///< what compare adds (CellRun::beside_s)
};

/// All runs that are missing: references first, then round after round over all cells, so that a
/// disturbance of the machine meets all of them. A cell whose run was not ok is not repeated.
/// `progress` is told how many of how many runs are done. Returns what those made now took.
TimeOfRuns run_missing(const std::filesystem::path& out, const ComparePlan& plan,
                       const Methods& methods,
                       const std::function<void(int done, int all)>& progress);

/// 16 hex digits, FNV-1a.
std::string text_hash(const std::string& text);
/// The same of this program's file, with its version; "" where the system does not name it.
std::string program_hash();

}  // namespace selvedge
