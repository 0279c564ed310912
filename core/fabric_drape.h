// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/measure.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge {

/// A disc of woven cloth, its yarns along x and y, `cells` across: the cells of a rectangular mesh
/// whose triangles lie in the disc, those at its rim pushed onto the circle. Throws
/// std::invalid_argument as make_rectangular does, and for fewer than 8 cells.
ClothMesh make_woven_disc(double radius, std::int32_t cells, const Material& material);

/// A drape test without bodies: the cloth is held flat where it lies on the support, so that only
/// the overhang moves, and nothing collides. Some points of the coefficient differ from those of a
/// cloth that rests on a support by friction.
struct DrapeTrial {
  double specimen = 0.15;   ///< m, radius of the cloth, > support
  double support = 0.09;    ///< m, radius of the support, > 0
  std::int32_t cells = 20;  ///< of the rim's size from the centre to the rim if polar, else across
  /// An arc mesh, whose shear has no warp and weft; else a woven disc, which needs cells of a third
  /// of the bending length and converges slowly (docs/fabrics.md).
  bool polar = true;
  /// How much farther apart rings are at the rim than at the support, >= 1, if polar: the weight of
  /// the overhang bends the cloth over the edge within a few millimetres, √(B/tension).
  double grading = 4.0;
  std::uint32_t seed = 1;    ///< of the heights that the cloth starts with, which choose its folds
  double noise = 1e-4;       ///< m, about the largest of them; the same surface on any mesh
  double step = 1.0 / 60.0;  ///< s, of the implicit integrator
  double damping = 0.05;     ///< s, of springs and hinges at least: the way to rest has no say
  double rest_speed = 5e-4;  ///< m/s, slower than this everywhere it is at rest
  std::int32_t most_steps = 1200;
};

/// What came of it.
struct DrapeOutcome {
  double coefficient = 0.0;  ///< %
  bool settled = false;      ///< at rest before the steps were used up
  std::int32_t steps = 0;
  RimProfile rim;
  TriangleMesh shape;  ///< at the end, m; the support is z = 0
};
/// Deterministic for any number of threads. Throws std::invalid_argument for bad numbers.
DrapeOutcome drape(const Material& material, const DrapeTrial& trial);
/// The drape of `trial` and `levels` - 1 with twice the cells of the one before, each of which
/// starts from the shape before, so that all have the same folds. `levels` >= 1. Polar meshes only.
std::vector<DrapeOutcome> drape_refined(const Material& material, const DrapeTrial& trial,
                                        std::int32_t levels);

/// What values on meshes of cells halved again and again tend to.
struct MeshLimit {
  double value = 0.0;
  double uncertainty = 0.0;  ///< of `value`, both ways, in its unit
  double order = 0.0;        ///< of convergence: that observed, within 1 and 2, or 2 of two values
};
/// Richardson's extrapolation with the uncertainty of P. J. Roache, "Perspective: a method for
/// uniform reporting of grid refinement studies", 1994: three times the correction of two values,
/// 1.25 times that of three. Of more values the last three count. Where these do not approach each
/// other, the uncertainty is the largest distance between two of them. Throws
/// std::invalid_argument for fewer than two.
MeshLimit mesh_limit(std::span<const double> values);

}  // namespace selvedge
