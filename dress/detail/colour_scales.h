// SPDX-License-Identifier: MIT
//
// What the pictures of a dressed garment show.
#pragma once

#include <selvedge/dress/dress.h>
#include <selvedge/pictures/renderer/internal/garment_views.h>

#include <cstddef>
#include <vector>

namespace selvedge::detail {

/// The largest principal strain of each triangle.
ColourScale strain_scale(const DressResult& r);
/// The pressure of the body on each triangle, Pa.
ColourScale pressure_scale(const DressResult& r);

/// Vertices of the garment and then of those below, at the end of the dressing, m.
std::vector<Vec3> all_cloth(const DressResult& r);

}  // namespace selvedge::detail
