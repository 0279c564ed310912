// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth_mesh.h>

#include <string>
#include <vector>

namespace selvedge::detail {

/// Warns of a piece that has an edge shorter than its rest gap. Contacts between such neighbours
/// keep a part of their starting distance, so the cloth cannot fold as sharply as its mesh allows.
void warn_of_rest_gap(const ClothMesh& piece, double rest_gap, const std::string& place,
                      std::vector<std::string>& warnings);

/// Refuses a rest gap of so many cells that nearly everything in the piece would be in contact with
/// everything. Throws std::invalid_argument with the fault and the remedy.
void refuse_rest_gap(const TriangleMesh& piece, double rest_gap);

}  // namespace selvedge::detail
