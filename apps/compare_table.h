// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/compare_error.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace selvedge {

/// Median and quartiles, by linear interpolation; all 0 of no values.
struct Quartiles {
  double median = 0.0, low = 0.0, high = 0.0;
};
Quartiles quartiles(std::vector<double> values);

/// One cell and what came of it.
struct CompareRow {
  std::string id, label;            ///< label: its values, "bvh_aabb, 0.004"
  std::string command;              ///< that runs it by itself
  std::vector<std::string> values;  ///< of the axes
  RunStatus status = RunStatus::ok;
  std::string why;      ///< where it is not ok
  std::string failure;  ///< a method broke its promise, or repeats differ; empty: none
  CellRun run;          ///< the first one
  int repeats = 0;      ///< runs that came to an end
  Quartiles run_s;      ///< s, all steps
  Quartiles ratio;      ///< time over that of the first cell, round by round
  std::map<std::string, double> phase_s;  ///< s, medians
  std::optional<double> error;            ///< over the extent of the cloth
  std::optional<double> deviation;        ///< the same from the first cell
  /// Its error stands above the reference's uncertainty, so that it may be plotted.
  bool counts = false;
  bool pareto = false;  ///< none is both quicker and nearer
};

/// What a compare has found so far.
struct CompareTable {
  ComparePlan plan;
  std::vector<CompareRow> rows;
  std::string reference;     ///< what it is, and how good
  double uncertainty = 0.0;  ///< over the extent of the cloth
  bool converges = false;
  std::string machine;

  bool failed() const;  ///< a method broke its promise
};

CompareTable make_table(const std::filesystem::path& out, const ComparePlan& plan,
                        const Methods& methods);

/// Names of the columns of the CSV that hold times or memory, and so differ from run to run.
bool is_measured(const std::string& column);
/// One line of names, then one a row. Empty: not known.
std::string to_csv(const CompareTable& table);
std::string to_json_text(const CompareTable& table);
/// For a terminal.
std::string to_text(const CompareTable& table);

/// `selvedge run SCENE --set ...` for one cell.
std::string command_of(const ComparePlan& plan, const CompareCell& cell);

/// Which processor, how many cores, which compiler.
std::string machine_in_words();

}  // namespace selvedge
