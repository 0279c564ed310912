// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/build.h>

namespace selvedge::detail {

/// Whether the scene prescribes something between `time` (s) and its last frame: a body or a handle
/// that moves, a release, water that begins or ends. Cloth that is at rest now will not stay so.
bool events_come(const Scene& scene, const BuiltScene& built, double time);

}  // namespace selvedge::detail
