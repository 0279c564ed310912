// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/garment/sewing_pattern.h>

namespace selvedge::detail {

/// A name of a file in quotes for messages, shortened, without control characters.
std::string quoted(const std::string& name);
/// Such as: edge 2 of panel "front", or line 0 of it.
std::string edge_name(const SewingPattern& pattern, const PatternStitch::Side& side);

}  // namespace selvedge::detail
