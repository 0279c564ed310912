// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/detail/scene_json.h>

namespace selvedge::detail {

/// What a grid or a mesh may have beside its shape, from a document that is checked and completed:
/// "layers", "plate", "refine" of a grid; "plate", "support" of a mesh.
void read_grid_options(const Json& geometry, ClothGrid& grid);
void read_mesh_options(const Json& geometry, ClothFile& mesh);
/// "virtual_springs" of either.
VirtualSpec read_virtual_springs(const Json& geometry);

}  // namespace selvedge::detail
