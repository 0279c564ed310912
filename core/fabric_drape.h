// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/measure.h>

#include <cstdint>

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
  std::int32_t cells = 20;  ///< from the centre to the rim if polar, else across the cloth
  /// An arc mesh, whose shear has no warp and weft; else a woven disc, which needs cells of a third
  /// of the bending length and converges slowly (docs/fabrics.md).
  bool polar = true;
  std::uint32_t seed = 1;    ///< of the heights that the cloth starts with, which choose its folds
  double noise = 1e-4;       ///< m, the largest of them
  double step = 1.0 / 60.0;  ///< s, of the implicit integrator
  double damping = 0.05;     ///< s, of springs and hinges at least: the way to rest has no say
  double rest_speed = 1e-3;  ///< m/s, slower than this everywhere it is at rest
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

}  // namespace selvedge
