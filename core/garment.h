// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth_mesh.h>

namespace selvedge {

/// A garment: `surface` is sewn, `pattern` is its cloth cut flat, triangle i that of triangle i of
/// the surface, m. Springs and hinges are those of the flat pieces; along a seam both sides have
/// their own springs, and it folds freely. Throws std::invalid_argument for patterns that do not
/// fit.
ClothMesh make_from_pattern(const TriangleMesh& surface, const TriangleMesh& pattern,
                            const Material& material);

}  // namespace selvedge
