// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/registry.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/core/patterns/make_yarn_cloth.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace selvedge {

/// How the support holds the cloth.
enum class DrapeHold {
  held,  ///< flat between two discs, so that only the overhang moves
  laid,  ///< on one disc, from which it can lift and on which it does not slide
};

/// The mesh of a drape test.
enum class DrapeMesh {
  arc,         ///< rings and spokes, whose shear does not distinguish warp and weft
  woven,       ///< cells of a grid cut to a disc; needs cells of a third of the bending length and
               ///< converges slowly (docs/fabrics.md)
  triangular,  ///< triangles in rings, which know no warp and weft
};

/// A simulated drape test without bodies or collisions.
struct DrapeTrial {
  double specimen = 0.15;  ///< m, radius of the cloth, > support
  double support = 0.09;   ///< m, radius of the support, > 0
  DrapeHold hold = DrapeHold::held;
  /// Of arc: cells from centre to rim, at the cell size of the rim; else cells across the disc.
  std::int32_t cells = 20;
  DrapeMesh mesh = DrapeMesh::arc;
  /// Ratio of the ring spacing at the rim to that at the support, >= 1; only of arc. The weight
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
/// and started from its final shape, so all have the same folds. `levels` >= 1; of arc only.
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
  /// Meshes of the first seed, each with twice the cells of the one before; 1: no refinement. Of
  /// arc only; the others are not refined.
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

/// A tension test of a small woven swatch, computed at the level of its yarns. No friction, gravity
/// or collisions. The grips let the swatch contract sideways.
struct SwatchTrial {
  WeaveConfig weave{.warp = {}, .weft = {}, .links = 4};
  double ends = 2500.0, picks = 2500.0;  ///< 1/m, warp yarns across and weft yarns along the warp
  std::int32_t crossings = 12;           ///< along each side, >= 8
  double strain = 0.1;                   ///< at the end of the test, > 0
  std::int32_t points = 20;              ///< equal steps of strain, >= 2

  /// Constants that follow without a test.
  double density() const;    ///< kg/m²
  WarpWeft crimp() const;    ///< mean length of a yarn over that of the cloth, less 1
  WarpWeft bending() const;  ///< N·m, rigidity of yarns that do not press on each other
  /// N/m. Initial modulus of a plain weave in closed form: the saw-tooth of [LeafKandil1980], with
  /// the stretch of yarns and the compression of crossings. Throws std::invalid_argument for other
  /// weaves.
  WarpWeft plain_modulus() const;
  double shear_modulus() const;  ///< N/m, of any weave, in closed form [LeafSheta1984]
};
/// Tension along warp or weft, of the middle half of the yarns; along the bias, of a swatch twice
/// as long as wide, between grips; or shear in a frame with hinged corners.
enum class SwatchPull { warp, weft, bias, shear };
/// A state of such a test.
struct SwatchPoint {
  double strain = 0.0;       ///< of the gauge, the middle of the swatch; of shear, rad
  double force = 0.0;        ///< N/m, per width at rest
  double contraction = 0.0;  ///< strain across, with the opposite sign
};
/// Tests a swatch step by step, each to equilibrium. The first point is the state at rest. Throws
/// std::invalid_argument if a number is out of range, and std::runtime_error if a step finds no
/// equilibrium.
std::vector<SwatchPoint> pull_swatch(const SwatchTrial& trial, SwatchPull pull);
/// Slope of the curve at rest, N/m: that of the parabola through the first three points.
double initial_modulus(std::span<const SwatchPoint> curve);
/// The fabric that an ordinary mesh can take over: density, the curves of warp, weft and shear, and
/// bending. Uses the laws `measured` and `angle`.
Material material_of(const SwatchTrial& trial, std::span<const SwatchPoint> warp,
                     std::span<const SwatchPoint> weft, std::span<const SwatchPoint> shear);

/// A tension test of a small knitted swatch, computed at the level of its yarn. No friction,
/// gravity or collisions. The surface is kept flat; the grips hold the outer half of the outermost
/// loops and let the swatch contract.
struct KnitTrial {
  KnitConfig knit{.yarn = {}};
  double wales = 1450.0, courses = 1650.0;  ///< 1/m, across and along the wales
  std::int32_t loops = 8;                   ///< along each side, >= 4
  double strain = 0.1;                      ///< at the end of the test, > 0
  std::int32_t points = 10;                 ///< equal steps of strain, >= 2

  KnitLoop loop() const;     ///< throws std::invalid_argument if the yarn does not fit
  double density() const;    ///< kg/m²
  double tightness() const;  ///< tightness factor: √tex over the loop length in cm
};
/// Along the courses, or along the wales.
enum class KnitPull { course, wale };
struct KnitTest {
  /// Strain of the grips; the contraction is that of the middle. The first point is at rest.
  std::vector<SwatchPoint> curve;
  double yarn_strain = 0.0;  ///< of the whole yarn at the last point
};
/// Tests a swatch step by step, each to equilibrium. Throws std::invalid_argument if a number is
/// out of range, and std::runtime_error if a step finds no equilibrium.
KnitTest pull_knit(const KnitTrial& trial, KnitPull pull);

/// Points of the catenary of `length` (m) between two points in gravity along -z, at these arc
/// lengths (m) from `a`. A `length` up to the distance of the points gives the straight line, in
/// proportion. Points above each other give a thread that hangs double. Throws
/// std::invalid_argument unless `length` is positive and finite and every arc length lies in [0,
/// length].
std::vector<Vec3> catenary(const Vec3& a, const Vec3& b, double length,
                           std::span<const double> arc);

/// A vertex of the grid that is held at a place.
struct HeldVertex {
  std::int32_t vertex;  ///< row by row as in make_rectangular
  Vec3 x;               ///< m
};
struct GeometricDrapeConfig {
  double tolerance = 1e-6;  ///< relaxation ends when no vertex moves more, in cell sides, > 0
  std::int32_t most_sweeps = 5000;  ///< >= 0; 0 leaves the catenaries as they are
};
/// The fields of GeometricDrapeConfig in order, as options with units and ranges.
std::vector<MethodOption> geometric_drape_options();

/// A drape without forces [Weil1986].
struct GeometricDrape {
  TriangleMesh shape;       ///< m
  std::int32_t curves = 0;  ///< catenaries that were traced
  std::int32_t sweeps = 0;  ///< of the relaxation
  double residual = 0.0;    ///< largest strain |L/L0 - 1| of sides and diagonals
};
/// Hangs a flat grid from held vertices by geometry alone: catenaries between the held vertices,
/// further ones across the triangles between them, and a relaxation to the lengths of the flat
/// cloth. The cloth has no weight and no stiffness; only its size matters. Cells outside the convex
/// hull of the held vertices hang straight down before the relaxation. Throws std::invalid_argument
/// for fewer than two held vertices, a vertex that is out of range or held twice, or two held
/// vertices farther apart than the cloth between them is long.
GeometricDrape drape_geometrically(const GridConfig& grid, std::span<const HeldVertex> held,
                                   const GeometricDrapeConfig& config = {});

}  // namespace selvedge
