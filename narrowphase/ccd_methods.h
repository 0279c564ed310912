// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <memory>

// The published methods beside ccd_exact, for comparison and for what is built on them. None is a
// substitute for ccd_exact where a collision must not be missed unless its traits say so.
//
// A tolerance that is not a number, and a minimum separation asked of a method that has none, are
// refused by std::invalid_argument.

namespace selvedge {

/// Roots of the coplanarity cubic in plain doubles and an inside test at each, without any
/// tolerance (the config's is not used): what a simulator does first, and the baseline of every
/// figure of speed.
std::unique_ptr<NarrowPhase> make_ccd_cubic(const NarrowPhaseConfig& config = {});

/// [Provot1997]: the same with a tolerance on the barycentric coordinates of the inside test,
/// `tolerance`, dimensionless, default 1e-6.
std::unique_ptr<NarrowPhase> make_ccd_cubic_provot(const NarrowPhaseConfig& config = {});

/// [Bridson2002]: at each root, and at the end of the step, the primitives collide if they are
/// nearer than `tolerance`, metres, default 1e-8.
std::unique_ptr<NarrowPhase> make_ccd_cubic_bridson(const NarrowPhaseConfig& config = {});

/// [survey] eq. (39), a point against the plane of a triangle at both ends of the step;
/// approximate. `tolerance` as of ccd_cubic_provot, default 0. Reports no edge pairs.
std::unique_ptr<NarrowPhase> make_plane_crossing(const NarrowPhaseConfig& config = {});

/// [ZhongXu2009], [survey] section 6.1.2: edges moved by the velocity of a centroid; approximate.
/// `tolerance`: how far along the motion an edge is sought, metres, default the way of the step.
/// Reports no point-triangle pairs.
std::unique_ptr<NarrowPhase> make_centroid_velocity(const NarrowPhaseConfig& config = {});

/// Nearer than `tolerance`, metres, default 1e-3, at the start or the end of the step; blind to
/// what happens between. A minimum separation raises the tolerance to it.
std::unique_ptr<NarrowPhase> make_proximity(const NarrowPhaseConfig& config = {});

struct CcdInclusionConfig {
  /// Which of the open parameter boxes is halved next: the earliest in time, which finds the first
  /// contact first, or the largest (breadth first), which says more when the boxes run out.
  enum class Order : std::uint8_t { time_first, breadth_first };

  /// A parameter box counts as contact once the differences on it vary by less than this part of
  /// the query's size (largest coordinate relative to the first vertex); in [2^-40, 1]. Smaller:
  /// fewer false alarms, more boxes.
  double tolerance = 0x1p-20;
  /// Metres: boxes count as contact where the differences may be this small along every axis. That
  /// holds earlier than that the distance is.
  double min_separation = 0.0;
  /// Boxes halved before it gives up and answers "collides" at the earliest time not proven free.
  int max_boxes = 1 << 16;
  Order order = Order::time_first;
};

/// [Snyder1992], [Redon2002], [Wang2021]: subdivision of (t, u, v) with inclusion boxes. Misses
/// nothing, its time is never later than the true one; false alarms within the tolerance and where
/// the boxes run out, which takes tens of milliseconds. `tolerance` is the one above.
std::unique_ptr<NarrowPhase> make_ccd_inclusion(const NarrowPhaseConfig& config = {});
std::unique_ptr<NarrowPhase> make_ccd_inclusion(const CcdInclusionConfig& config);

struct CcdAdditiveConfig {
  /// It stops where the distance is below this part of that at t = 0, in (0, 1); also the part of
  /// each step that is not taken. Smaller: fewer false alarms, more steps.
  double gap = 0.1;
  /// Metres, taken off all distances.
  double min_separation = 0.0;
  /// Steps before it gives up and answers "collides" at the time it has reached.
  int max_steps = 1 << 16;
};

/// [Li2021]: steps by distance over speed. Misses nothing, its time is never later than the true
/// one but earlier by what closing the last tenth of the distance takes; false alarms where the
/// primitives only come near, or touch at t = 0 within rounding. `tolerance` is `gap`.
std::unique_ptr<NarrowPhase> make_ccd_additive(const NarrowPhaseConfig& config = {});
std::unique_ptr<NarrowPhase> make_ccd_additive(const CcdAdditiveConfig& config);

/// [Brochu2012]: parity of the crossings of a ray with the image of the parameter domain's
/// boundary, every sign exact. Misses an even number of contacts in one step; gives no time.
/// Has no tolerance.
std::unique_ptr<NarrowPhase> make_ccd_root_parity(const NarrowPhaseConfig& config = {});

}  // namespace selvedge
