// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>

#include <string>

namespace selvedge::detail {

/// Smallest and largest corner of a box; empty if lo > hi.
struct Bounds {
  Vec3 lo, hi;
};

/// Throws std::invalid_argument if the two position arrays differ in length or the thickness is not
/// a finite number >= 0. `name` starts the message. Takes constant time.
void check_shape(const SurfaceView& surface, const std::string& name);

/// Throws std::invalid_argument that names the first edge or triangle with an index outside [0, n).
void check_indices(const SurfaceView& surface, const std::string& name);

/// Throws std::invalid_argument that names the first vertex that is not finite; otherwise returns
/// the box around x_t0.
Bounds check_finite(const SurfaceView& surface, const std::string& name);

}  // namespace selvedge::detail
