// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <memory>

// The published methods besides ccd_exact, for comparison and as building blocks. Where a collision
// must not be missed, use ccd_exact unless a method's traits promise that it misses nothing.
//
// Each factory throws std::invalid_argument for a tolerance that is NaN or infinite, and for a
// minimum separation that the method does not support.

namespace selvedge {

/// Options of make_ccd_exact.
struct CcdExactConfig {
  /// Maximum number of doubles in the filters' vectors (2, 4 or 8), limited by the processor. The
  /// results are the same bits for each width. Eight has not been faster than four in measurements.
  int vector_width = 4;
};

/// The default narrow phase. It never misses a collision and never reports a false one, for any
/// finite doubles, and its time of impact is the largest double not later than the true time.
/// Proven floating-point filters decide nearly all pairs; integer arithmetic decides the rest.
std::unique_ptr<NarrowPhase> make_ccd_exact(const CcdExactConfig& config = {});

/// The default method with a minimum separation d > 0, metres: primitives collide when their
/// distance is at most d. Conservative: it misses nothing, and its time is not later than the first
/// one at which the distance is d or less. It may stop early: the distance at the reported time is
/// at most d + (d/64 + 2^-40 L) 2^(steps / 4096), where L is the largest coordinate of the vertices
/// relative to the first one during the step. The last factor guarantees termination; only
/// specially constructed motion needs 4096 steps of advancement. d = 0 is allowed, but then d/64
/// vanishes and make_ccd_exact is the better choice. A contact's normal is the direction between
/// the closest points at the reported time.
///
/// Throws std::invalid_argument for a separation that is negative or not finite.
std::unique_ptr<NarrowPhase> make_ccd_separation(double min_separation);

/// Number of queries that each stage decided; for tests and reports.
struct CcdExactStages {
  std::size_t separated = 0;       ///< A: on opposite sides along an axis during the whole step
  std::size_t never_coplanar = 0;  ///< B: the coplanarity cubic has one strict sign
  std::size_t isolated = 0;        ///< C: root isolation and inside tests with error bounds
  std::size_t exact = 0;           ///< D and E: integer arithmetic
};

/// NarrowPhase::find_times of the default method; adds its counts to `stages`.
void find_times_counting_stages(std::span<const Query> queries, std::span<double> toi,
                                CcdExactStages& stages);

/// Roots of the coplanarity cubic in plain doubles and an inside test at each, without tolerances
/// (ignores the config's): the usual first implementation, and the baseline of all timings.
std::unique_ptr<NarrowPhase> make_ccd_cubic(const NarrowPhaseConfig& config = {});

/// [Provot1997]: the same with a tolerance on the barycentric coordinates of the inside test:
/// `tolerance`, dimensionless, default 1e-6.
std::unique_ptr<NarrowPhase> make_ccd_cubic_provot(const NarrowPhaseConfig& config = {});

/// [Bridson2002]: the primitives collide if they are nearer than `tolerance`, metres, default 1e-8,
/// at a root of the coplanarity cubic or at the end of the step.
std::unique_ptr<NarrowPhase> make_ccd_cubic_bridson(const NarrowPhaseConfig& config = {});

/// [survey] eq. (39): tests a point against the plane of a triangle at both ends of the step;
/// approximate. `tolerance` as in ccd_cubic_provot, default 0. Reports no edge pairs.
std::unique_ptr<NarrowPhase> make_plane_crossing(const NarrowPhaseConfig& config = {});

/// [ZhongXu2009], [survey] section 6.1.2: moves edges with the velocity of a centroid; approximate.
/// `tolerance`: how far along the motion an edge is searched, metres, default the distance moved in
/// the step. Reports no point-triangle pairs.
std::unique_ptr<NarrowPhase> make_centroid_velocity(const NarrowPhaseConfig& config = {});

/// Primitives collide if they are nearer than `tolerance`, metres, default 1e-3, at the start or
/// the end of the step; motion in between is ignored. A minimum separation above the tolerance
/// replaces it.
std::unique_ptr<NarrowPhase> make_proximity(const NarrowPhaseConfig& config = {});

/// Options of `ccd_inclusion`.
struct CcdInclusionConfig {
  /// Which open parameter box is halved next: the earliest in time, which finds the first contact
  /// first, or the largest (breadth first), which gives more information when the boxes run out.
  enum class Order : std::uint8_t { time_first, breadth_first };

  /// A parameter box counts as a contact once the difference vectors on it vary by less than this
  /// fraction of the query's size (largest coordinate relative to the first vertex); in [2^-40, 1].
  /// Smaller: fewer false alarms, more boxes.
  double tolerance = 0x1p-20;
  /// Metres: boxes count as contacts where the differences may be this small along every axis. This
  /// occurs earlier than the distance itself becomes this small.
  double min_separation = 0.0;
  /// Maximum number of boxes halved per query; then the method answers "collides" at the earliest
  /// time not proven free.
  int max_boxes = 1 << 16;
  Order order = Order::time_first;
};

/// [Snyder1992], [Redon2002], [Wang2021]: subdivision of (t, u, v) with inclusion boxes. Misses
/// nothing, and its time is never later than the true one. False alarms occur within the tolerance,
/// and where the boxes run out, which takes tens of milliseconds. `tolerance` is
/// CcdInclusionConfig::tolerance.
std::unique_ptr<NarrowPhase> make_ccd_inclusion(const NarrowPhaseConfig& config = {});
/// The same with all options. Throws std::invalid_argument for an option out of its range.
std::unique_ptr<NarrowPhase> make_ccd_inclusion(const CcdInclusionConfig& config);

/// Options of `ccd_additive`.
struct CcdAdditiveConfig {
  /// The method stops when the distance is below this fraction of the distance at t = 0, in (0, 1);
  /// it is also the fraction of each step that is not taken. Smaller: fewer false alarms, more
  /// steps.
  double gap = 0.1;
  /// Metres, subtracted from all distances.
  double min_separation = 0.0;
  /// Maximum number of steps per query; then the method answers "collides" at the time it has
  /// reached.
  int max_steps = 1 << 16;
};

/// [Li2021]: advances by distance over speed. Misses nothing; its time is earlier than the true one
/// by the time that closing the last `gap` of the distance takes, never later. False alarms occur
/// where primitives come near without touching, or are within rounding of contact at t = 0.
/// `tolerance` is CcdAdditiveConfig::gap.
std::unique_ptr<NarrowPhase> make_ccd_additive(const NarrowPhaseConfig& config = {});
/// The same with all options. Throws std::invalid_argument for an option out of its range.
std::unique_ptr<NarrowPhase> make_ccd_additive(const CcdAdditiveConfig& config);

/// [Brochu2012]: parity of the crossings of a ray with the image of the parameter domain's
/// boundary; every sign is exact. Misses an even number of contacts in one step; gives no time. Has
/// no tolerance.
std::unique_ptr<NarrowPhase> make_ccd_root_parity(const NarrowPhaseConfig& config = {});

}  // namespace selvedge
