// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

namespace selvedge {

/// The files of one state of a result folder.
struct ResultState {
  std::filesystem::path cloth, bodies;  ///< `bodies` is empty where the scene has none
};

/// What there is to judge in a result folder (layout: scene/output.h).
struct ResultStates {
  std::vector<ResultState> states;
  /// Every accepted state in order, so that the straight path from each to the next is what was
  /// promised to be free; else the frames, between which there were other states.
  bool every_step = false;
};

/// Throws std::invalid_argument with one sentence if there is no frame, or if a file is missing
/// without which the judgement would say less than it seems to: a state, or the bodies.
ResultStates result_states(const std::filesystem::path& folder);

}  // namespace selvedge
