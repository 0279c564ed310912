// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/detail/mesh_source.h>
#include <selvedge/bodies/internal/animation_file.h>

#include <functional>
#include <string>
#include <vector>

namespace selvedge::detail {

/// What a file states: metres per unit (0: nothing) and up axis (1 to 3 for x to z; 0: nothing;
/// negative: the negative axis).
struct StatedAxes {
  double unit = 0.0, up = 0.0;
};

/// The axes with which a file is read: the settings, else what it states, else metres and z up.
/// Throws std::invalid_argument that begins with `name` if it states a negative axis.
FileAxes axes_of(const LoadConfig& config, const StatedAxes& stated, const std::string& name);
/// The settings with these axes.
LoadConfig with_axes(LoadConfig config, const FileAxes& axes);

/// Runs selvedge-assimp on a file; `more` are its arguments after the limits. `decode` returns
/// false unless the output is complete. Throws std::invalid_argument with the fault otherwise.
void read_assimp_output(const std::filesystem::path& file, const LoadConfig& config,
                        const std::vector<std::string>& more,
                        const std::function<bool(const std::string& output)>& decode);

/// The points of a .pc2 or .mdd cache, without triangles.
MeshAnimation read_pc2(const MeshSource& source);
MeshAnimation read_mdd(const MeshSource& source);
/// The meshes of a USD stage, in its unit and axes, which it states.
MeshAnimation read_usda(const MeshSource& source, StatedAxes& stated);

}  // namespace selvedge::detail
