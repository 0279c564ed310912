// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge {

/// The methods that `--broad-phase a,b` or `--narrow-phase all` selects.
struct MethodChoice {
  std::vector<std::string> names;
  /// True for all methods of this build; methods that do not support the case are skipped with a
  /// note.
  bool all = false;
};

/// Throws std::invalid_argument for a name that this build does not have.
template <class Registry>
MethodChoice choose_methods(const std::vector<std::string>& asked, const Registry& registry,
                            const std::string& option) {
  MethodChoice choice;
  choice.all = std::find(asked.begin(), asked.end(), "all") != asked.end();
  if (choice.all) choice.names = registry.names();
  for (const std::string& name : asked) {
    if (const std::string fault = registry.fault(name); name != "all" && !fault.empty())
      throw std::invalid_argument(option + ": " + fault);
    if (std::find(choice.names.begin(), choice.names.end(), name) == choice.names.end() &&
        name != "all")
      choice.names.push_back(name);
  }
  return choice;
}

/// The narrow-phase options of the command line. If all methods are selected, a tolerance applies
/// only to methods that have one.
inline MethodOptions narrow_options(const std::vector<MethodOption>& known,
                                    const NarrowPhaseConfig& config, bool all) {
  MethodOptions options;
  if (config.tolerance >= 0.0) options.set("tolerance", config.tolerance);
  if (all) options = known_options(known, options);
  if (config.min_separation != 0.0) options.set("min_separation", config.min_separation);
  return options;
}

/// The message of a method without the method's name as prefix.
inline std::string without_name(const std::string& name, const std::string& sentence) {
  const std::string front = name + ": ";
  return sentence.starts_with(front) ? sentence.substr(front.size()) : sentence;
}

}  // namespace selvedge
