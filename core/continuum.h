// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth_mesh.h>

namespace selvedge {

/// Constants of a sheet in its plane, N/m: energy per area
///   ½ (C11 εx² + C22 εy² + 2 C12 εx εy + C33 γ² + 2 C13 εx γ + 2 C23 εy γ),
/// x the warp, y the weft, γ the shear angle.
struct ContinuumConstants {
  double c11 = 0.0, c22 = 0.0, c12 = 0.0, c33 = 0.0, c13 = 0.0, c23 = 0.0;
};

/// What a flat mesh really has: its energy under a small uniform strain, by area. `rest`: positions
/// in the xy-plane (z is ignored). Exact where every particle is a centre of symmetry, else an
/// upper bound, as particles could move to lower the energy. Springs that resist only tension count
/// in full. Throws std::invalid_argument unless area is positive.
ContinuumConstants continuum_constants(const ClothMesh& cloth, std::span<const Vec3> rest,
                                       double area);

/// Force per width and strain along warp of a strip with free sides that may shear, 1/(C⁻¹)11; N/m.
double strip_modulus(const ContinuumConstants& c);
/// How much it narrows per stretch, -(C⁻¹)12/(C⁻¹)11.
double strip_poisson(const ContinuumConstants& c);

/// A plate of Young's modulus times thickness `stretch` (N/m) and Poisson's ratio `poisson`.
ContinuumConstants plate_constants(double stretch, double poisson);

/// |a - b|/|b| as tensors.
double relative_distance(const ContinuumConstants& a, const ContinuumConstants& b);

/// The least relative_distance of any net of springs to `c`: springs alone have C12 = C33 (Cauchy),
/// so that an isotropic net has Poisson's ratio 1/3 and no other.
double cauchy_residual(const ContinuumConstants& c);

}  // namespace selvedge
