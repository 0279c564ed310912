// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/render.h>
#include <selvedge/core/measure.h>
#include <selvedge/scene/measures.h>

namespace selvedge {

/// What a strain picture shows.
struct StrainView {
  std::span<const Vec3> x;
  std::span<const Triangle> triangles;
  std::span<const TriangleStrain> strains;  ///< of each triangle
  std::span<const RenderSurface> others;    ///< drawn beside, e.g. bodies
  double range = 0.01;                      ///< strain of the full colour, > 0
};
/// Triangles from blue (-range) through white to red (+range) by the principal strain that is
/// larger in size.
Image draw_strain(const Camera& camera, const StrainView& view);

/// Seen from above: the support light, the cloth's shadow dark, its rim as sampled red, north is
/// +y.
Image draw_shadow(std::span<const Vec3> x, std::span<const Triangle> triangles,
                  const DrapeMeasures& drape, const DrapeSupport& support);

/// Bars of the amplitudes of orders 1 to 24, the strongest from 2 on red.
Image draw_spectrum(const RimProfile& rim);

}  // namespace selvedge
