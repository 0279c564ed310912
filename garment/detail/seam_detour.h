// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/garment/sewing_pattern.h>

namespace selvedge::detail {

/// Sum of the distances between the ends of two sewn edges that meet this way round, relative to
/// that of the other way round.
double seam_detour(const SewingPattern& pattern, const PatternStitch& stitch, bool start_to_start);

}  // namespace selvedge::detail
