// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/pybind11.h>
#include <selvedge/core/base/registry.h>

#include <string>

namespace selvedge::python {

/// A method by name, with options.
struct MethodChoice {
  std::string name;
  MethodOptions options;
};

/// From {"type": name, option: value, ...}, as in scene files.
inline MethodChoice method_choice(const pybind11::dict& given) {
  MethodChoice choice;
  for (const auto& [key, value] : given) {
    const auto name = key.cast<std::string>();
    if (name == "type")
      choice.name = value.cast<std::string>();
    else
      choice.options.set(name, value.cast<double>());
  }
  return choice;
}

}  // namespace selvedge::python
