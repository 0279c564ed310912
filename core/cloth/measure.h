// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/cloth_elements.h>
#include <selvedge/core/cloth/cloth_mesh.h>

#include <span>
#include <vector>

namespace selvedge {

/// Area of the union of the triangles projected along z, m²: the shadow in Cusick's drape tester.
/// Exact to rounding, by a sweep over the lines between which the outline of the shadow is
/// straight; nothing is sampled. Throws std::invalid_argument for an invalid index or coordinate.
double projected_area(std::span<const Vec3> x, std::span<const Triangle> triangles);

/// Area of a surface, m².
double surface_area(std::span<const Vec3> x, std::span<const Triangle> triangles);

/// Cusick's drape coefficient in percent, 100 (shadow - support)/(specimen - support), areas in m²:
/// 100 for a stiff disc, 0 for one that hangs straight down [Cusick1968]. Throws
/// std::invalid_argument unless 0 < support < specimen.
double drape_coefficient(double shadow, double specimen, double support);

/// Vertices of the longest loop of boundary edges, in order; empty for a closed surface.
std::vector<std::int32_t> rim_of(std::span<const Vec3> x, std::span<const Triangle> triangles);

/// The rim of a drape as seen from above.
struct RimProfile {
  /// m, at equal angles starting at +x; the outermost radius if the rim overhangs.
  std::vector<double> radius;
  std::vector<double> height;  ///< m, at the same angles
  /// m, amplitude of cos n·angle in the radius, for n from 0 (the mean).
  std::vector<double> amplitude;
  int folds = 0;  ///< the n >= 2 with the largest amplitude; 0 for a round rim
  /// Number of maxima of the radius with a prominence of more than a tenth of its range.
  int maxima = 0;
};

/// Sampling of a rim.
struct RimConfig {
  Vec3 centre = Vec3::Zero();  ///< m; only x and y are used
  int samples = 720;           ///< number of angles, >= 8
};

/// Radius of the rim as a function of the angle about the centre, and its spectrum (discrete
/// Fourier transform). Throws std::invalid_argument if the surface has no rim or the centre lies
/// outside it.
RimProfile rim_profile(std::span<const Vec3> x, std::span<const Triangle> triangles,
                       const RimConfig& config);

/// Strain of a triangle: the principal stretches of its deformation gradient minus 1.
struct TriangleStrain {
  double larger = 0.0, smaller = 0.0;  ///< principal strains, larger >= smaller >= -1
  double area = 0.0;                   ///< m², of the rest shape
};
/// Strains of the triangles from `rest` to `x`. Triangle i of `rest` corresponds to triangle i of
/// `triangles` but may have its own vertices. Zero for a triangle without area at rest.
std::vector<TriangleStrain> triangle_strains(std::span<const Vec3> x,
                                             std::span<const Triangle> triangles,
                                             const TriangleMesh& rest);

/// Statistics of many strains.
struct StrainSummary {
  double max = 0.0, min = 0.0;  ///< the largest and smallest strain
  double rms = 0.0;             ///< root mean square
  double mean = 0.0;
};
/// Statistics of both principal strains, weighted by area.
StrainSummary summary_of(std::span<const TriangleStrain> strains);
/// Statistics of the spring strains (L-L0)/L0, equally weighted.
StrainSummary spring_strains(std::span<const Spring> springs, std::span<const Vec3> x);

/// Heuristic lower bound of the drape coefficient, in percent, of an 18 cm support and a 30 cm
/// specimen. `bending_length` in m. Model: free radial strips without hoop stress; the overhang of
/// 6 cm hangs like the elastica of a heavy cantilever strip.
double strip_drape_coefficient(double bending_length);

/// In-plane constants of a sheet, N/m. Energy per area:
///   ½ (C11 εx² + C22 εy² + 2 C12 εx εy + C33 γ² + 2 C13 εx γ + 2 C23 εy γ),
/// with x along the warp, y along the weft and γ the shear angle.
struct ContinuumConstants {
  double c11 = 0.0, c22 = 0.0, c12 = 0.0, c33 = 0.0, c13 = 0.0, c23 = 0.0;
};

/// Effective continuum constants of a flat mesh: its energy under a small uniform strain, per area.
/// `rest` gives positions in the xy-plane (z is ignored). The result is exact if every particle is
/// a centre of symmetry; otherwise it is an upper bound, because the particles could move to lower
/// the energy. Tension-only springs count in full. Throws std::invalid_argument unless `area` is
/// positive.
ContinuumConstants continuum_constants(const ClothMesh& cloth, std::span<const Vec3> rest,
                                       double area);

/// The constants of a sheet that follows a membrane law. With a flat rest shape, free strips have
/// the material's stretch along warp and weft; C33 is its shear stiffness, or 0 if torsional
/// springs resist shear; C12 follows from `poisson` or equals C33. Warp and weft have no direction
/// on a rest shape that is not flat: it is isotropic with the mean stretch, and with Poisson's
/// ratio 1/3 unless the material gives one.
ContinuumConstants membrane_constants(const Material& material, bool flat);

/// Force per width and strain along the warp of a strip with free sides that may shear: 1/(C⁻¹)11,
/// N/m.
double strip_modulus(const ContinuumConstants& c);
/// Contraction of such a strip per stretch: -(C⁻¹)12/(C⁻¹)11.
double strip_poisson(const ContinuumConstants& c);

/// Constants of an isotropic plate. `stretch`: Young's modulus times thickness, N/m; `poisson`:
/// Poisson's ratio.
ContinuumConstants plate_constants(double stretch, double poisson);

/// Relative distance |a - b|/|b| in the tensor norm.
double relative_distance(const ContinuumConstants& a, const ContinuumConstants& b);

/// Smallest relative_distance to `c` that a net of springs can reach. Springs alone have C12 = C33
/// (Cauchy's relation), so an isotropic net always has Poisson's ratio 1/3.
double cauchy_residual(const ContinuumConstants& c);

}  // namespace selvedge
