// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

namespace selvedge {

struct CcdExactConfig {
  /// The filters use vectors of at most so many doubles (2, 4 or 8), as wide as the processor has
  /// them; the answers are the same bits. Eight have not been quicker than four where measured.
  int vector_width = 4;
};

/// The default narrow phase: never misses a collision and never reports a false one, on any finite
/// doubles, and its time of impact is the largest double not later than the true one. Proven
/// floating-point filters settle nearly all pairs, integer arithmetic the rest.
std::unique_ptr<NarrowPhase> make_ccd_exact(const CcdExactConfig& config = {});

/// The default method with a minimum separation d > 0, metres: the primitives collide where they
/// are no further than d apart. Conservative: it misses nothing, and its time is not later than the
/// first one at which the distance is d or less. It may stop early: the distance at the time that
/// it reports is at most d + (d/64 + 2^-40 L) 2^(steps / 4096), L the largest coordinate of the
/// vertices relative to the first one, during the step; after 4096 steps of advancement, which
/// only motion made for it needs, that reserve doubles, so that it ends. d = 0 is allowed: then
/// d/64 is nothing, and make_ccd_exact the better choice. A contact's normal is the direction
/// between the closest points at that time.
///
/// Throws std::invalid_argument for a separation that is negative or not finite.
std::unique_ptr<NarrowPhase> make_ccd_separation(double min_separation);

/// How many queries each stage settled; for tests and reports.
struct CcdExactStages {
  std::size_t separated = 0;       ///< A: on opposite sides along an axis during the whole step
  std::size_t never_coplanar = 0;  ///< B: the coplanarity cubic has one strict sign
  std::size_t isolated = 0;        ///< C: root isolation and inside tests with error bounds
  std::size_t exact = 0;           ///< D and E: integer arithmetic
};

/// NarrowPhase::find_times of the default method, adding to `stages`.
void find_times_counting_stages(std::span<const Query> queries, std::span<double> toi,
                                CcdExactStages& stages);

}  // namespace selvedge
