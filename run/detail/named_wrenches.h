// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/run/frame_writer.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/step_report.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace selvedge::detail {

/// Whether the formats of a scene name "wrenches".
bool wants_wrenches(const Scene& scene);

/// Of a simulation of the scene: bodies and handles about the mean of their vertices, held vertices
/// about their place, and what acted on the cloth about the origin.
std::vector<NamedWrench> named_wrenches(const Scene& scene, const Simulation& simulation,
                                        const StepWrenches& wrenches);

/// The means over the last frame as measures of result.json.
std::map<std::string, double> wrench_measures(const Scene& scene, const Simulation& simulation);

/// Writes `file` anew with each frame.
std::unique_ptr<FrameWriter> make_wrench_table(const std::filesystem::path& file);

}  // namespace selvedge::detail
