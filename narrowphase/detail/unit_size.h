// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

namespace selvedge::narrowphase_detail {

/// Four relative paths: y[k](t) = 2^e (x[k](t) - x[3](t)).
struct UnitSizePaths {
  std::array<Vec3, 4> y_t0, y_t1;
  /// Largest path among them, in the new unit: how far one primitive moves against the other.
  double motion = 0.0;
};

/// The query seen from its last vertex, and scaled by the power of two that brings the larger
/// primitive, at the time it is larger, to a size in [1, 2): for libraries with absolute
/// tolerances. Collisions and their times are those of the query, but for the rounding of the
/// differences; scaling by a power of two changes no digit short of overflow. Primitives that are
/// single points leave the size of the whole, or 0 if that is a point too.
UnitSizePaths to_unit_size(const Query& query);

}  // namespace selvedge::narrowphase_detail
