// SPDX-License-Identifier: MIT
//
// Pictures of a garment on a body.
#pragma once

#include <selvedge/core/base/types.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// A garment in one pose, as its pictures show it.
struct PicturedGarment {
  std::span<const Vec3> cloth;  ///< m, of the garment and then of those below
  std::span<const Triangle> triangles;
  const TriangleMesh& pattern;  ///< m, flat: its triangle i is triangle i of the garment
  std::span<const std::int32_t> panel_of_triangle;
  std::vector<const TriangleMesh*> below;  ///< garments below: their triangles
  std::span<const Vec3> body;              ///< m
  std::span<const Triangle> body_triangles;
};

/// Values of the triangles that a picture shows, from 0 to `top`; larger ones look like `top`.
struct ColourScale {
  std::vector<double> values;
  double top = 0.0;
};

/// NAMEfront.png and NAMEback.png: each panel with the grid of its pattern; garments below are
/// grey.
void draw_panels(const std::filesystem::path& folder, const std::string& name,
                 const PicturedGarment& garment);
/// The same with the garment in the colours of a scale.
void draw_scale(const std::filesystem::path& folder, const std::string& name,
                const PicturedGarment& garment, const ColourScale& scale);
/// The same from front, back, left and right (of the wearer, who faces -y), with a colour for each
/// triangle, linear RGB.
void draw_coloured(const std::filesystem::path& folder, const std::string& name,
                   const PicturedGarment& garment, std::span<const Vec3> colours);

}  // namespace selvedge
