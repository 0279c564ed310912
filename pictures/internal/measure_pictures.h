// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/pictures/renderer/render.h>
#include <selvedge/run/measure_result.h>

#include <filesystem>
#include <span>

namespace selvedge {

/// Draws strain.png and, with a drape, shadow.png and spectrum.png into a folder. The camera and
/// the bodies are those of the result.
void draw_measures(const ResultMeasures& measures, const std::filesystem::path& result,
                   const std::filesystem::path& folder);

/// Input of a strain picture.
struct StrainView {
  std::span<const Vec3> x;
  std::span<const Triangle> triangles;
  std::span<const TriangleStrain> strains;  ///< one per triangle
  std::span<const RenderSurface> others;    ///< drawn as well, e.g. bodies
  double range = 0.01;                      ///< strain at full colour, > 0
};
/// Colours each triangle from blue (-range) through white to red (+range) by the principal strain
/// with the larger magnitude.
Image draw_strain(const Camera& camera, const StrainView& view);

/// View from above, with +y pointing up: the support is light, the shadow of the cloth dark, its
/// sampled rim red.
Image draw_shadow(std::span<const Vec3> x, std::span<const Triangle> triangles,
                  const DrapeMeasures& drape, const DrapeSupport& support);

/// Bar chart of the amplitudes of orders 1 to 24. The strongest order from 2 upwards is red.
Image draw_spectrum(const RimProfile& rim);

}  // namespace selvedge
