// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/parallel.h>
#include <selvedge/core/base/types.h>

namespace selvedge::detail {

/// Scalar field: negative inside, positive outside, approximately the distance near the surface.
/// Must be callable from any thread.
using Field = FunctionRef<double(const Vec3&)>;

/// How an implicit surface is meshed.
struct ImplicitSurfaceConfig {
  Vec3 lower, upper;    ///< m, a box around the surface
  double cell = 0.016;  ///< m, cell size of the grid; finer details are lost
  int faces = 10000;    ///< target number of faces, limited by the number that the grid yields
  /// m; where the surface is curved more tightly than this radius, faces become smaller.
  double curved_radius = 0.05;
  int relaxations = 10;  ///< number of smoothing passes along the surface
};

/// Closed, manifold, outward-oriented mesh of the zero set of the field: marching tetrahedra
/// [DoiKoide1991] on the Kuhn triangulation of a grid, then edge collapses down to the target
/// number of faces; every vertex is projected back onto the surface by Newton's method.
/// Bit-identical for any number of threads. Thin folds may cause self-intersections, which the
/// caller has to check for.
TriangleMesh mesh_implicit_surface(Field field, const ImplicitSurfaceConfig& config);

}  // namespace selvedge::detail
