// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

#include <filesystem>
#include <string>
#include <vector>

struct CaseOptions {
  std::filesystem::path data;                                 ///< the folder of the scenes
  std::vector<std::string> cases;                             ///< empty: all
  std::vector<std::string> responses, integrators, limiters;  ///< empty: those of each scene
  std::filesystem::path out;                                  ///< for frames; empty: none
  int threads = 0;                                            ///< 0: no limit
  double limit = 120.0;                                       ///< s per scene
  bool json = false;
};

/// The options of `selvedge stability` that apply only to a folder.
void add_case_options(const selvedge::Command& group, CaseOptions& options);

/// Runs the scenes of a folder, a row each: correct, refused with the reason, degraded with the
/// flag, or FAILED. Returns the exit code: 1 if one failed.
int run_cases(const CaseOptions& options);
