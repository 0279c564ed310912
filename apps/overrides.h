// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>

#include <stdexcept>
#include <string>
#include <vector>

/// The values of `option`, each "path=value". Throws std::invalid_argument for anything else.
inline std::vector<selvedge::Override> read_overrides(const std::vector<std::string>& set,
                                                      const std::string& option = "--set") {
  std::vector<selvedge::Override> overrides;
  for (const std::string& text : set) {
    const auto equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      throw std::invalid_argument(option + " " + text +
                                  ": must be path=value, such as time.frames=30");
    overrides.push_back({text.substr(0, equals), text.substr(equals + 1)});
  }
  return overrides;
}
