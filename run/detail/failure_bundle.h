// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/run/internal/replay.h>

#include <filesystem>

namespace selvedge::detail {

/// Keeps the state of `simulation` and its last failed attempt; replaces an older bundle. Throws
/// std::runtime_error with file and cause where a file cannot be written.
void write_failure_bundle(const std::filesystem::path& folder, const Scene& scene,
                          const Simulation& simulation, const SimulationFailed& failure);

/// Removes the files of a bundle, and nothing else.
void remove_failure_bundle(const std::filesystem::path& folder);

}  // namespace selvedge::detail
