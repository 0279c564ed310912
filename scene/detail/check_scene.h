// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>

namespace selvedge::detail {

/// Checks the numbers of a scene made in code; the parser checks those of scene files. Throws
/// std::invalid_argument with the field and its value for a number that is not finite or out of
/// range.
void check_numbers(const Scene& scene);

}  // namespace selvedge::detail
