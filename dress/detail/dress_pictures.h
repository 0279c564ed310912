// SPDX-License-Identifier: MIT
//
// Pictures of a dressed garment.
#pragma once

#include <selvedge/dress/dress.h>

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

/// How a triangle is deformed: its area in the flat pattern (twice, m²), and the gradient of its
/// place over the pattern.
struct Deformation {
  double area = 0.0;
  Eigen::Matrix<double, 3, 2> gradient;
};
Deformation deformation(const DressResult& r, std::size_t triangle);

/// Values of the triangles that a picture shows, from 0 to `top`; larger ones look like `top`.
struct ColourScale {
  std::vector<double> values;
  double top = 0.0;
};
/// The largest principal strain of each triangle.
ColourScale strain_scale(const DressResult& r);
/// The pressure of the body on each triangle, Pa.
ColourScale pressure_scale(const DressResult& r);

/// All garments and the body in one pose.
struct Worn {
  std::span<const Vec3> cloth;  ///< m, of the garment and then of those below
  std::span<const Vec3> body;   ///< m
};

/// Vertices of the garment and then of those below, at the end of the dressing, m.
std::vector<Vec3> all_cloth(const DressResult& r);

/// NAMEfront.png and NAMEback.png: each panel with the grid of its pattern; garments below are
/// grey.
void draw_dressed(const std::filesystem::path& folder, const std::string& name,
                  const DressResult& result, const Worn& worn);
/// The same with the garment in the colours of a scale.
void draw_scale(const std::filesystem::path& folder, const std::string& name,
                const DressResult& result, const ColourScale& scale);

}  // namespace selvedge::detail
