// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>

#include <string>
#include <vector>

namespace selvedge {

/// One thing that a compare varies.
struct CompareAxis {
  /// As the user wrote it: a short name (see short_axes) or a path of the scene file.
  std::string name;
  std::vector<std::string> values;  ///< as `--set` takes them, each once
  bool numeric = false;             ///< all of them numbers: points along a line of the plot
};

/// Short names of --vary and the scene keys they stand for; "mesh", "dt" and "threads" are no
/// single key.
std::vector<std::pair<std::string, std::string>> short_axes();

/// Reads what --vary was given, each "NAME=a,b,c", "NAME=lo..hi:n" with "log" after it for equal
/// ratios, "NAME=all", or "NAME,NAME,..." for all of each. Throws std::invalid_argument for an
/// unknown name (the nearest one is offered), an empty or malformed list, and for "all" of a key
/// that has no list of values.
std::vector<CompareAxis> read_axes(const std::vector<std::string>& vary, const Methods& methods);

/// The full product, or the first value of each axis with one axis at a time varied.
enum class CompareDesign { product, one_at_a_time };

/// The values of each cell, in the order of the axes; the last axis changes fastest. Throws
/// std::invalid_argument beyond ten thousand cells.
std::vector<std::vector<std::string>> design_cells(const std::vector<CompareAxis>& axes,
                                                   CompareDesign design);

/// What a cell replaces in the scene. Throws std::invalid_argument where the value of "dt", "mesh"
/// or "threads" is none.
std::vector<Override> cell_overrides(const std::vector<CompareAxis>& axes,
                                     const std::vector<std::string>& values, const Scene& base);

/// Value of the axis of this name in a cell; "" without such an axis.
std::string axis_value(const std::vector<CompareAxis>& axes, const std::vector<std::string>& values,
                       const std::string& name);

/// Overrides that make the steps dt seconds long, or a little shorter so that they end with the
/// scene, and cut the time into other frames only where a step is longer than a frame.
std::vector<Override> step_overrides(const Scene& base, double dt);

/// Length of a nominal step, s.
double nominal_step(const Scene& scene);

}  // namespace selvedge
