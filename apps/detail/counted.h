// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace selvedge {

/// "1 step" or "6 steps"; for nouns with a regular plural.
template <class Count>
std::string counted(Count count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

}  // namespace selvedge
