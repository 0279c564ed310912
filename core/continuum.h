// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth_mesh.h>

namespace selvedge {

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
