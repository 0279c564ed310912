// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/compare/detail/trial.h>

#include <functional>
#include <string>
#include <vector>

/// The project's acceptance cases: scenes of data/extreme, each with an answer known in advance.
namespace selvedge::extreme_test {

using detail::CaseResult;
using detail::JudgedRun;
using detail::Trial;

struct ExtremeCase {
  std::string name;  ///< of its scene, or of the first one
  Answer best;       ///< the expected answer
  bool quick;        ///< takes less than a few seconds
  std::function<CaseResult(Trial&)> run;
};

/// S1 to S25 of the project's list, and further cases. The two halves: numbers and files, contact.
std::vector<ExtremeCase> number_cases();
std::vector<ExtremeCase> contact_cases();

}  // namespace selvedge::extreme_test
