// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/compare_folder.h>

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace selvedge {

/// What a user asks of a compare.
struct CompareRequest {
  std::filesystem::path scene;
  std::vector<Override> set;            ///< for all cells, the reference included
  std::vector<Override> reference_set;  ///< for the reference alone
  std::vector<std::string> vary;
  CompareDesign design = CompareDesign::product;
  bool reference = true;  ///< if there is something to refine and to compare
  int repeats = 7;
  CellLimits limits;
  std::string command;
};

/// A plan and the scenes of all its cells and reference levels, by folder name.
struct PlannedCompare {
  ComparePlan plan;
  std::vector<std::pair<std::string, std::string>> scene_of_id;
};

/// Reads scene and axes and tries whether every cell can start; `note` is told of those that
/// cannot, which are marked and left out. Throws std::invalid_argument for what no cell can do.
PlannedCompare plan_compare(const CompareRequest& request, const Methods& methods,
                            const std::function<void(const std::string&)>& note);

}  // namespace selvedge
