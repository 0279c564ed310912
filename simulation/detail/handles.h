// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/parallel.h>
#include <selvedge/scene/build.h>

namespace selvedge::detail {

/// Throws std::invalid_argument for a handle of an unknown piece or vertex. The reader checks scene
/// files; this is the first check of a scene made in code.
void refuse_bad_handles(const Scene& scene, const BuiltScene& built);

/// Visits every particle that is held at time t0, with its prescribed position at t1, m, and the
/// number of its handle.
void visit_held(
    const Scene& scene, const BuiltScene& built, double t0, double t1,
    FunctionRef<void(std::int32_t particle, const Vec3& end, std::int32_t handle)> visit);

}  // namespace selvedge::detail
