// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/force.h>
#include <selvedge/scene/scene.h>

#include <memory>
#include <vector>

namespace selvedge::detail {

/// What acts on the cloth of a scene, contacts aside.
std::vector<std::unique_ptr<Force>> make_forces(const Scene& scene, const BuiltScene& built);

/// The seams of a scene alone.
std::vector<std::unique_ptr<Force>> make_seams(const Scene& scene, const BuiltScene& built);

}  // namespace selvedge::detail
