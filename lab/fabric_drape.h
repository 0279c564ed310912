// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/measure.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace selvedge {

/// A simulated drape test without bodies or collisions: the cloth is held flat over the support, so
/// only the overhang moves. The coefficient can differ by a few percentage points from that of a
/// cloth that rests on a support with friction.
struct DrapeTrial {
  double specimen = 0.15;  ///< m, radius of the cloth, > support
  double support = 0.09;   ///< m, radius of the support, > 0
  /// If polar: cells from centre to rim, at the cell size of the rim; else cells across the disc.
  std::int32_t cells = 20;
  /// True: an arc mesh, whose shear does not distinguish warp and weft. False: a woven disc, which
  /// needs cells of a third of the bending length and converges slowly (docs/fabrics.md).
  bool polar = true;
  /// Ratio of the ring spacing at the rim to that at the support, >= 1; only if polar. The weight
  /// of the overhang bends the cloth over the edge within a few millimetres, √(B/tension).
  double grading = 4.0;
  /// Seed of the initial height noise, which selects the folds.
  std::uint32_t seed = 1;
  /// m, approximate largest height of the noise; the same surface on any mesh.
  double noise = 1e-4;
  double step = 1.0 / 60.0;  ///< s, step of the implicit integrator
  /// s, lower bound of the damping of springs and hinges; it does not affect the rest shape.
  double damping = 0.05;
  /// m/s; the cloth is at rest when every particle is slower than this.
  double rest_speed = 5e-4;
  /// Maximum number of steps.
  std::int32_t most_steps = 1200;
};

/// Result of a simulated drape test.
struct DrapeOutcome {
  double coefficient = 0.0;  ///< %
  bool settled = false;      ///< came to rest within the allowed steps
  std::int32_t steps = 0;
  RimProfile rim;
  TriangleMesh shape;  ///< final shape, m; the support lies at z = 0
};
/// Runs the drape test. Deterministic for any number of threads. Throws std::invalid_argument if a
/// number is out of range.
DrapeOutcome drape(const Material& material, const DrapeTrial& trial);
/// Runs `trial` and then `levels` - 1 refinements, each with twice the cells of the previous one
/// and started from its final shape, so all have the same folds. `levels` >= 1; polar meshes only.
std::vector<DrapeOutcome> drape_refined(const Material& material, const DrapeTrial& trial,
                                        std::int32_t levels);

/// Extrapolated limit of a value under mesh refinement.
struct MeshLimit {
  double value = 0.0;
  double uncertainty = 0.0;  ///< ± this much, in the unit of `value`
  /// Order of convergence: the observed one, clamped to [1, 2], or 2 if there are only two values.
  double order = 0.0;
};
/// Richardson extrapolation of values on meshes whose cell size is halved each time, with the
/// uncertainty of P. J. Roache, "Perspective: a method for uniform reporting of grid refinement
/// studies", 1994: three times the correction for two values, 1.25 times for three. Of more values
/// only the last three are used. If these do not converge, the uncertainty is the largest distance
/// between two of them. Throws std::invalid_argument for fewer than two values.
MeshLimit mesh_limit(std::span<const double> values);

/// Drape tests of one fabric that differ in their seed.
struct DrapeSeries {
  DrapeTrial trial;        ///< its seed is replaced by 1, 2, ...
  std::int32_t seeds = 5;  ///< >= 1
  /// Meshes of the first seed, each with twice the cells of the one before; 1: no refinement. Polar
  /// meshes only; others are not refined.
  std::int32_t levels = 2;
};

struct DrapeStatistics {
  std::vector<double> coefficient;          ///< %, of each seed
  std::vector<std::int32_t> folds;          ///< of each seed
  std::vector<double> refined;              ///< %, of the first seed on each of its meshes
  std::vector<std::int32_t> refined_folds;  ///< of the first seed on each of its meshes
  std::int32_t unsettled = 0;               ///< tests that did not come to rest
  double strips = 0.0;                      ///< %, strip_drape_coefficient of the fabric

  double mean() const;    ///< % of the seeds
  double spread() const;  ///< %, largest minus smallest of the seeds
  /// Limit of the mean for finer meshes: every seed gets the correction of the first one. nullopt
  /// without refinement.
  std::optional<MeshLimit> limit() const;
  double value() const;  ///< %, the limit if it is known, else the mean
};
/// Runs the tests, in parallel over the seeds. Deterministic for any number of threads. Throws
/// std::invalid_argument if a number is out of range.
DrapeStatistics drape_series(const Material& material, const DrapeSeries& series);

}  // namespace selvedge
