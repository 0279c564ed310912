// SPDX-License-Identifier: MIT
//
// Views of a garment on a body.
#pragma once

#include <selvedge/core/base/types.h>
#include <selvedge/pictures/renderer/render.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// A garment in one pose, as its views show it.
struct PicturedGarment {
  std::span<const Vec3> cloth;  ///< m, of the garment and then of those below
  std::span<const Triangle> triangles;
  const TriangleMesh& pattern;  ///< m, flat: its triangle i is triangle i of the garment
  std::span<const std::int32_t> panel_of_triangle;
  std::vector<const TriangleMesh*> below;  ///< garments below: their triangles
  std::span<const Vec3> body;              ///< m
  std::span<const Triangle> body_triangles;
};

/// Values of the triangles that a view shows, from 0 to `top`; larger ones look like `top`.
struct ColourScale {
  std::vector<double> values;
  double top = 0.0;
};

/// A garment seen from one side of the wearer, who faces -y.
struct GarmentView {
  std::string side;  ///< front, back, left or right
  Image picture;
};

/// Front and back: each panel with the grid of its pattern; garments below are grey.
std::vector<GarmentView> views_of_panels(const PicturedGarment& garment);
/// The same with the garment in the colours of a scale.
std::vector<GarmentView> views_by_scale(const PicturedGarment& garment, const ColourScale& scale);
/// From all four sides, with a colour for each triangle, linear RGB.
std::vector<GarmentView> views_by_colour(const PicturedGarment& garment,
                                         std::span<const Vec3> colours);

}  // namespace selvedge
