// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/simulation/simulation.h>

#include <filesystem>

namespace selvedge::detail {

/// Writes frames/ and queries/ of a failure bundle from the last failed attempt: the colliding
/// primitives, or the particle with a position that is not finite, with the triangles around them;
/// and the colliding pairs as queries. A state with a position that is not finite is not written,
/// and then there are no queries.
void write_offenders(const std::filesystem::path& folder, const Simulation& simulation);

}  // namespace selvedge::detail
