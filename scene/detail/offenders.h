// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/simulation.h>

#include <filesystem>

namespace selvedge::detail {

/// Writes frames/ and queries/ of a failure bundle from the last failed try: the primitives that
/// collide, or the particle without a position, with the triangles at them; and the queries. A
/// state with positions that are not finite is left out, and so are the queries then.
void write_offenders(const std::filesystem::path& folder, const Simulation& simulation);

}  // namespace selvedge::detail
