// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

namespace selvedge::detail {

/// Four relative paths: y[k](t) = 2^e (x[k](t) - x[3](t)).
struct UnitSizePaths {
  std::array<Vec3, 4> y_t0, y_t1;
  /// Longest of these paths, in the new unit: how far one primitive moves relative to the other.
  double motion = 0.0;
};

/// The query relative to its last vertex, scaled by the power of two that brings the larger
/// primitive, at the time it is larger, to a size in [1, 2): for libraries with absolute
/// tolerances. Collisions and their times are those of the query up to the rounding of the
/// differences; scaling by a power of two is exact unless it overflows. For two single points the
/// size is that of all vertices, or 0 if they coincide.
UnitSizePaths to_unit_size(const Query& query);

}  // namespace selvedge::detail
