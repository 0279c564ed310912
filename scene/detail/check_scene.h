// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>

#include <string>
#include <vector>

namespace selvedge::detail {

/// Checks the numbers of a scene made in code; the parser checks those of scene files. Throws
/// std::invalid_argument with the field and its value for a number that is not finite or out of
/// range.
void check_numbers(const Scene& scene);

/// One sentence for each turn of more than half a circle between two keyframes of the text from
/// which the scene was read (read_values.cpp): rotations in memory no longer tell.
std::vector<std::string> turn_warnings(const Scene& scene);

}  // namespace selvedge::detail
