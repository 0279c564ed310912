// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/patterns/internal/adaptive_cloth.h>
#include <selvedge/scene/build.h>

namespace selvedge {

/// The conditions of "refine"; null: the mesh of the piece stays.
const RefineSpec* refine_of(const ClothSpec& cloth);

/// The cells of a piece with "refine": a grid for the pattern "rectangular", triangles for other
/// patterns and for meshes. Throws std::invalid_argument if the pattern or an option is unsuited.
AdaptiveCloth make_adaptive_cloth(const ClothSpec& cloth, const Material& material,
                                  const ClothPatternRegistry& patterns);

}  // namespace selvedge
