// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <cstdint>

namespace selvedge::narrowphase_detail {

/// The largest double not above the root of the coplanarity cubic in the box [k, k + 1] / 2^m, on
/// which the cubic is monotonic and changes sign. In double-double arithmetic with an error bound;
/// false where that does not settle it. The query is one that stage C has settled.
bool floor_of_root(const Query& query, std::int64_t k, int m, double& root);

}  // namespace selvedge::narrowphase_detail
