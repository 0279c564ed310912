// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/detail/scene_json.h>

namespace selvedge::detail {

/// Read the options beside the shape from a checked and completed document: "plate" and "refine" of
/// a grid; "plate" and "support" of a mesh.
void read_grid_options(const Json& geometry, ClothGrid& grid);
void read_mesh_options(const Json& geometry, ClothFile& mesh);
/// Reads "virtual_springs" of a grid or a mesh.
VirtualSpec read_virtual_springs(const Json& geometry);

}  // namespace selvedge::detail
