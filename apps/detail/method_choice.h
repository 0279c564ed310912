// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
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

/// What a method says against its use, without its own name in front.
inline std::string without_name(const std::string& name, const std::string& sentence) {
  const std::string front = name + ": ";
  return sentence.starts_with(front) ? sentence.substr(front.size()) : sentence;
}

/// Refuses what is no number of at least 0 (the checks of the command-line library would print the
/// largest double).
inline std::string refuse_negative(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  const bool good = !text.empty() && *end == 0 && value >= 0.0 && std::isfinite(value);
  return good ? std::string() : text + " must be a number of at least 0";
}

}  // namespace selvedge
