// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/parallel.h>
#include <selvedge/scene/scene.h>

namespace selvedge::detail {

/// Throws std::invalid_argument for a handle of a piece or vertex that there is not. A scene file
/// is checked by its reader; one made in code is seen here first.
void refuse_bad_handles(const Scene& scene, const BuiltScene& built);

/// Every particle that is held at time t0, with where it is prescribed to be at t1, m.
void visit_held(const Scene& scene, const BuiltScene& built, double t0, double t1,
                FunctionRef<void(std::int32_t particle, const Vec3& end)> visit);

}  // namespace selvedge::detail
