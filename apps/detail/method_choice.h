// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge {

/// What `--broad-phase a,b` or `--narrow-phase all` asks for.
struct MethodChoice {
  std::vector<std::string> names;
  /// Everything this build has; what does not serve the case is left out and said.
  bool all = false;
};

/// Throws std::invalid_argument for a name that this build does not have.
template <class Registry>
MethodChoice choose_methods(const std::vector<std::string>& asked, const Registry& registry,
                            const std::string& option) {
  MethodChoice choice;
  choice.all = std::find(asked.begin(), asked.end(), "all") != asked.end();
  std::string known;
  for (const auto& entry : registry) {
    known += (known.empty() ? "" : ", ") + entry.first;
    if (choice.all) choice.names.push_back(entry.first);
  }
  for (const std::string& name : asked) {
    if (name != "all" && !registry.contains(name))
      throw std::invalid_argument(option + ": there is no \"" + name + "\" in this build; it has " +
                                  known);
    if (std::find(choice.names.begin(), choice.names.end(), name) == choice.names.end() &&
        name != "all")
      choice.names.push_back(name);
  }
  return choice;
}

}  // namespace selvedge
