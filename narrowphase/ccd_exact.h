// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

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

}  // namespace selvedge
