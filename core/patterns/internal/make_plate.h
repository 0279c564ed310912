// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/cloth_mesh.h>

namespace selvedge {

/// A plate of isotropic material.
struct PlateConstants {
  double stretch = 500.0;      ///< N/m, Young's modulus times thickness, > 0
  double poisson = 1.0 / 3.0;  ///< in (-1, 1)
  double thickness = 5e-4;     ///< m, > 0; bending by D = stretch·thickness²/(12 (1-poisson²))
};
/// Plate model [WangDevarajan2008; survey 3.1]: springs on the edges of a flat mesh, fitted to a
/// plate, and the residual of the fit.
struct PlateMesh {
  ClothMesh cloth;
  double residual = 0.0;  ///< area-weighted rms of |C_net - C|/|C| of the triangles
  double worst = 0.0;     ///< largest residual of a triangle
};
/// `rest` lies in a plane of constant z. Only density, damping and strain limit are taken from
/// `material`.
PlateMesh make_plate(const TriangleMesh& rest, const PlateConstants& plate,
                     const Material& material);

}  // namespace selvedge
