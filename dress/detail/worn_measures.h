// SPDX-License-Identifier: MIT
//
// What a tailor sees of a worn garment.
#pragma once

#include <selvedge/dress/detail/dressing.h>
#include <selvedge/dress/dress.h>

namespace selvedge::detail {

/// Fills folded, panel_folded, tight, and asymmetry of a result that has its garment and its body.
/// `start` and `worn` are the garment before the sewing and now; `middle` is the x of a person
/// between left and right, m, else that of the pattern counts.
void measure_worn(const Garment& start, const Garment& worn, std::optional<double> middle,
                  DressResult& result);

/// Share of the area of each panel that lies over itself: another layer of the same panel with the
/// opposite face is within 5 mm along the outward normal of the body.
std::vector<double> folded_areas(const TriangleMesh& garment,
                                 std::span<const std::int32_t> panel_of_triangle,
                                 const TriangleMesh& body, std::size_t panels);

/// Lengths around a section of a garment and of the body in it, m; 0: no closed section.
struct Girth {
  double cloth = 0.0;  ///< in the flat pattern
  double worn = 0.0;
  double body = 0.0;  ///< of a tape around the body
};
/// In the plane through the middle of a triangle with this normal.
Girth girth_at(const TriangleMesh& garment, const TriangleMesh& flat, const TriangleMesh& body,
               std::size_t triangle, const Vec3& normal);

}  // namespace selvedge::detail
