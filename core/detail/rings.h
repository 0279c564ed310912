// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth_mesh.h>

#include <vector>

namespace selvedge::detail {

/// An arc mesh (see make_arc) with rings of these radii in m, ascending, numbered as there.
ClothMesh make_rings(const std::vector<double>& radii, std::int32_t spokes,
                     const Material& material);

}  // namespace selvedge::detail
