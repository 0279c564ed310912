// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/parallel.h>
#include <selvedge/core/triangle_mesh.h>

namespace selvedge::detail {

/// Negative inside, positive outside, close to a distance near the surface; called from any thread.
using Field = FunctionRef<double(const Vec3&)>;

struct ImplicitSurfaceConfig {
  Vec3 lower, upper;            ///< m, a box around the surface
  double cell = 0.016;          ///< m, edge of the grid's cells: finer details are lost
  int faces = 10000;            ///< wanted, at most what the cells give
  double curved_radius = 0.05;  ///< m, on surfaces curved more tightly the faces become smaller
  int relaxations = 10;         ///< rounds of smoothing along the surface
};

/// Closed, manifold, outward-oriented mesh of the surface where the field is 0: marching tetrahedra
/// [DoiKoide1991] on the Kuhn triangulation of a grid, then edge collapse to the wanted number of
/// faces, every vertex drawn back onto the surface by Newton's method. Same bits for any number of
/// threads. The caller checks for self-intersections, which thin folds may still cause.
TriangleMesh mesh_implicit_surface(Field field, const ImplicitSurfaceConfig& config);

}  // namespace selvedge::detail
