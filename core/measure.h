// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth_mesh.h>

#include <span>
#include <vector>

namespace selvedge {

/// Area of the union of the triangles seen along z, m²: the shadow that Cusick's lamp casts. A
/// sweep over the lines between which the outline of the shadow is straight, so that nothing is
/// sampled: exact to rounding. Throws std::invalid_argument for a broken index or coordinate.
double projected_area(std::span<const Vec3> x, std::span<const Triangle> triangles);

/// Area of a surface, m².
double surface_area(std::span<const Vec3> x, std::span<const Triangle> triangles);

/// Cusick's drape coefficient in percent, 100 (shadow - support)/(specimen - support), areas in m²:
/// 100 for a stiff disc, 0 for one that hangs straight down [Cusick1968]. Throws
/// std::invalid_argument unless the specimen is larger than the support and the support positive.
double drape_coefficient(double shadow, double specimen, double support);

/// The longest loop of edges that belong to one triangle only, in order; empty for a closed
/// surface.
std::vector<std::int32_t> rim_of(std::span<const Vec3> x, std::span<const Triangle> triangles);

/// The rim of a drape seen from above.
struct RimProfile {
  std::vector<double> radius;  ///< m, at equal angles from +x on; the outermost where it overhangs
  std::vector<double> height;  ///< m, there
  std::vector<double> amplitude;  ///< m, of cos n·angle in the radius, n from 0 (the mean)
  int folds = 0;                  ///< the n >= 2 of the largest amplitude; 0 for a round rim
  int maxima = 0;  ///< of the radius that stand out by more than a tenth of its range
};

/// How a rim is sampled.
struct RimConfig {
  Vec3 centre = Vec3::Zero();  ///< m, only x and y count
  int samples = 720;           ///< angles, >= 8
};

/// The rim's radius over the angle about the centre and its spectrum (a discrete Fourier transform,
/// direct). Throws std::invalid_argument for a surface without a rim and a centre outside of it.
RimProfile rim_profile(std::span<const Vec3> x, std::span<const Triangle> triangles,
                       const RimConfig& config);

/// Strain of each triangle: its deformation gradient's principal stretches less 1.
struct TriangleStrain {
  double larger = 0.0, smaller = 0.0;  ///< principal strains, larger >= smaller >= -1
  double area = 0.0;                   ///< m², at rest
};
/// `x` against `rest`, whose triangle i is that of `triangles` and may have vertices of its own.
/// Zero for a triangle without area at rest.
std::vector<TriangleStrain> triangle_strains(std::span<const Vec3> x,
                                             std::span<const Triangle> triangles,
                                             const TriangleMesh& rest);

/// What many strains come to.
struct StrainSummary {
  double max = 0.0, min = 0.0;  ///< the largest and smallest strain
  double rms = 0.0;             ///< root of the mean square
  double mean = 0.0;
};
/// Of the two principal strains, weighted by area.
StrainSummary summary_of(std::span<const TriangleStrain> strains);
/// Of the springs, (L-L0)/L0, each alike.
StrainSummary spring_strains(std::span<const Spring> springs, std::span<const Vec3> x);

/// Lower bound (heuristic: free radial strips, no hoop stress) of the drape coefficient of an 18 cm
/// support and a 30 cm specimen, in percent, for a cloth of bending length `c`, m: the shadow of a
/// disc whose overhang of 6 cm hangs as the strip elastica of the heavy cantilever.
double strip_drape_coefficient(double bending_length);

}  // namespace selvedge
