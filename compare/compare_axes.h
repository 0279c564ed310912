// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>

#include <string>
#include <vector>

namespace selvedge {

/// One parameter that a comparison varies.
struct CompareAxis {
  /// The name that the user wrote: a short name (see short_axes) or a path of the scene file.
  std::string name;
  std::vector<std::string> values;  ///< in the form that `--set` accepts; no duplicates
  bool numeric = false;             ///< all values are numbers, so the plot joins them by a line
};

/// Short names of --vary and the scene keys that they stand for. "mesh", "dt" and "threads"
/// correspond to no single key.
std::vector<std::pair<std::string, std::string>> short_axes();

/// Parses the arguments of --vary. Each has one of the forms "NAME=a,b,c", "NAME=lo..hi:n"
/// (followed by "log" for equal ratios), "NAME=all", or "NAME,NAME,..." for all values of each.
/// Throws std::invalid_argument for an unknown name (and suggests the nearest one), for an empty or
/// malformed list, and for "all" of a key without a list of values.
std::vector<CompareAxis> read_axes(const std::vector<std::string>& vary, const Methods& methods);

/// The full product, or the first value of each axis with one axis varied at a time.
enum class CompareDesign { product, one_at_a_time };

/// The values of each cell, in the order of the axes; the last axis changes fastest. Throws
/// std::invalid_argument if there are more than ten thousand cells.
std::vector<std::vector<std::string>> design_cells(const std::vector<CompareAxis>& axes,
                                                   CompareDesign design);

/// The overrides that a cell applies to the scene. Throws std::invalid_argument if a value of "dt",
/// "mesh" or "threads" is not valid.
std::vector<Override> cell_overrides(const std::vector<CompareAxis>& axes,
                                     const std::vector<std::string>& values, const Scene& base);

/// Value of the named axis in a cell; "" if there is no such axis.
std::string axis_value(const std::vector<CompareAxis>& axes, const std::vector<std::string>& values,
                       const std::string& name);

/// Overrides that set the step length to dt seconds, or slightly less so that a whole number of
/// steps fills the scene's duration. They change the frames only if a step is longer than a frame.
std::vector<Override> step_overrides(const Scene& base, double dt);

/// Length of a nominal step, s.
double nominal_step(const Scene& scene);

}  // namespace selvedge
