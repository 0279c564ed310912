// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/detail/ccd_filter.h>
#include <selvedge/narrowphase/detail/root_isolation.h>

namespace selvedge::detail {

/// Decides, by stage C, a query whose vertices are coplanar at all times and whose primitives do
/// not touch at t = 0. If they collide, toi is the largest double not later than the true time.
ContactDecision first_contact_in_plane(const FilterKernel& kernel, const Query& query, double& toi);

}  // namespace selvedge::detail
