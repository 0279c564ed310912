// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/garment/sewing_pattern.h>

#include <string>

namespace selvedge {

/// Drawing of the flat panels of a pattern that check_sewing_pattern accepts: an SVG document whose
/// unit is the millimetre. Each edge has its number and, if it is sewn, the number of its stitch in
/// a colour that both sides share; the ends that meet have the same mark. `labels` of edges are
/// written along them. A bar of 10 cm gives the scale.
std::string pattern_svg(const SewingPattern& pattern);

}  // namespace selvedge
