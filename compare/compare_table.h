// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/compare/compare_plan.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace selvedge {

/// Median and quartiles, by linear interpolation; all 0 without values.
struct Quartiles {
  double median = 0.0, low = 0.0, high = 0.0;
};
Quartiles quartiles(std::vector<double> values);

/// One cell and its results.
struct CompareRow {
  std::string id, label;            ///< label: its values, such as "bvh_aabb, 0.004"
  std::string command;              ///< runs the cell alone
  std::vector<std::string> values;  ///< one per axis
  RunStatus status = RunStatus::ok;
  std::string why;      ///< the reason, if the status is not ok
  std::string failure;  ///< broken promise of a method, or differing repeats; empty if none
  CellRun run;          ///< the first run
  int repeats = 0;      ///< runs that finished
  Quartiles run_s;      ///< s, all steps
  Quartiles ratio;      ///< time over that of the first cell, round by round
  std::map<std::string, double> phase_s;  ///< s, medians
  std::optional<double> error;            ///< in the quantity of the plan
  double error_half = 0.0;                ///< half its 90 % interval over the seeds; 0: no seeds
  std::optional<double> deviation;        ///< the same relative to the first cell
  std::map<std::string, double> errors;   ///< in every quantity that has a reference
  /// True if the error exceeds the uncertainty of the reference and its own interval, so that it
  /// may be plotted.
  bool counts = false;
  bool pareto = false;  ///< no other cell is both faster and more accurate
};

/// Results of a comparison so far.
struct CompareTable {
  ComparePlan plan;
  std::vector<CompareRow> rows;
  std::string reference;   ///< its kind and accuracy
  std::string error_unit;  ///< as it follows a number: "of the cloth's extent"
  std::string error_meaning;
  double uncertainty = 0.0;  ///< of the reference, in this unit
  bool converges = false;
  std::string machine;

  bool failed() const;  ///< a method broke its promise
};

CompareTable make_table(const std::filesystem::path& out, const ComparePlan& plan,
                        const Methods& methods);

/// Names of the CSV columns that hold times or memory and therefore differ from run to run.
bool is_measured(const std::string& column);
/// One line of names, then one line per row. An empty field means unknown.
std::string to_csv(const CompareTable& table);
std::string to_json_text(const CompareTable& table);
/// What the errors can tell apart, in one sentence: how many groups of cells have intervals that do
/// not overlap; or that they rank nothing, and the size of the comparison that could.
std::string ranking(const CompareTable& table);
/// Formats the table for a terminal.
std::string to_text(const CompareTable& table);

/// The `selvedge run SCENE --set ...` command for one cell.
std::string command_of(const ComparePlan& plan, const CompareCell& cell);

/// Names the processor, the number of cores and the compiler.
std::string machine_in_words();

struct PageConfig {
  bool pictures = true;    ///< thumbnails of the final frames
  int most_pictures = 60;  ///< for the first rows; more would make the page megabytes large
};

/// A self-contained HTML file with plots, table, bars and pictures. It links the page of a cell,
/// cells/ID/view.html, where that exists.
std::string compare_page(const std::filesystem::path& out, const CompareTable& table,
                         const PageConfig& config = {});

/// The page template without data (compare_page.html, compiled in).
const char* compare_page_template();

}  // namespace selvedge
