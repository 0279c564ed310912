// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/compare/compare_folder.h>

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace selvedge {

/// The user's request for a comparison.
struct CompareRequest {
  std::filesystem::path scene;
  std::vector<Override> set;            ///< for all cells and the reference
  std::vector<Override> reference_set;  ///< for the reference only
  std::vector<std::string> vary;
  CompareDesign design = CompareDesign::product;
  bool reference = true;  ///< if there is a parameter to refine and a value to compare
  int repeats = 7;
  CellLimits limits;
  std::string command;
};

/// A plan and the scenes of all its cells and reference levels, by folder name.
struct PlannedCompare {
  ComparePlan plan;
  std::vector<std::pair<std::string, std::string>> scene_of_id;
};

/// Reads the scene and the axes and checks whether every cell can start. Cells that cannot start
/// are marked, skipped and reported to `note`. Throws std::invalid_argument for an error that
/// concerns all cells.
PlannedCompare plan_compare(const CompareRequest& request, const Methods& methods,
                            const std::function<void(const std::string&)>& note);

}  // namespace selvedge
