// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/types.h>

#include <cstdint>
#include <filesystem>
#include <string>

namespace selvedge {

/// Where two runs part.
struct RunDifference {
  bool every_step = false;  ///< steps were compared, else frames
  int compared = 0;         ///< states that both runs have and that are the same, from the start
  int states_a = 0, states_b = 0;
  bool differ = false;  ///< there is a state that both have and that differs
  /// Of the first state that differs:
  int number = -1;            ///< of the step or frame
  std::string surface;        ///< "cloth" or "bodies"
  std::int32_t vertex = -1;   ///< the first that differs, in the file
  std::int64_t vertices = 0;  ///< how many do
  Vec3 x_a, x_b;              ///< m, of the first
  double distance = 0.0;      ///< m, largest between the positions of one vertex
  double speed = 0.0;         ///< m/s, largest between the velocities of one vertex
  std::string structure;      ///< "" or why vertex by vertex makes no sense: other numbers of them
};

/// Compares the states of two result folders bit for bit in order of time: every accepted step if
/// both have steps/, else the frames. Throws std::invalid_argument for a folder without states and
/// for a damaged file.
RunDifference find_difference(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace selvedge
