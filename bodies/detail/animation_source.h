// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/animation_file.h>
#include <selvedge/bodies/detail/mesh_source.h>

#include <functional>
#include <string>
#include <vector>

namespace selvedge::detail {

/// Runs selvedge-assimp on a file; `more` are its arguments after the limits. `decode` returns
/// false unless the output is complete. Throws std::invalid_argument with the fault otherwise.
void read_assimp_output(const std::filesystem::path& file, const LoadConfig& config,
                        const std::vector<std::string>& more,
                        const std::function<bool(const std::string& output)>& decode);

/// The points of a .pc2 or .mdd cache, without triangles.
MeshAnimation read_pc2(const MeshSource& source);
MeshAnimation read_mdd(const MeshSource& source);
/// The meshes of a USD stage, in metres and with z up.
MeshAnimation read_usda(const MeshSource& source);

}  // namespace selvedge::detail
