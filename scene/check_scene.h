// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>

namespace selvedge {

/// Refuses numbers that a scene file could not hold: not finite, or outside their range. For scenes
/// made in code, which no parser has seen. Throws std::invalid_argument with the field and its
/// value.
void check_numbers(const Scene& scene);

}  // namespace selvedge
