// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/narrowphase/narrow_phase.h>
#include <selvedge/narrowphase/query_file.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace selvedge {

/// One step of two surfaces, or of one surface against itself; in that case b is the same view as
/// a.
struct DetectionCase {
  SurfaceView a, b;
  bool self = false;
};

/// The reference pairs that detectors are compared with.
struct ReferencePairs {
  std::string boxes_from;    ///< the detector that found `boxes`
  CandidatePairs boxes;      ///< pairs whose swept boxes overlap
  CandidatePairs colliding;  ///< the subset that collides, by ccd_exact
};

/// Number of box tests that brute force would make.
double brute_force_tests(const DetectionCase& c);
/// This many box tests take about a second.
inline constexpr double kMomentTests = 2e8;
/// Uses brute force for at most `most_tests` box tests. Beyond that it uses the tree that reports
/// the same pairs, or sweep and prune if that tree is the detector to be judged.
ReferencePairs reference_pairs(const DetectionCase& c, double most_tests = kMomentTests,
                               const std::string& judged = {});

/// The reason why a detector does not support this case; empty if it does.
std::string why_not(const BroadPhaseTraits& traits, const DetectionCase& c);

/// Errors of a detector that answers particles, at the end of the step and against exact distances
/// from the triangles.
struct ParticleScore {
  double reach = 0.0;            ///< m, the sum of the two thicknesses
  std::size_t touching = 0;      ///< particles inside the body or nearer to it than the reach
  std::size_t missed = 0;        ///< of them, without a contact
  std::size_t false_alarms = 0;  ///< contacts of other particles
  double max_depth_error = 0.0, mean_depth_error = 0.0;  ///< m, of the contacts that are right
  double max_normal_error = 0.0;  ///< degrees from the direction to the nearest point, likewise
};

/// Compares the contacts that `detector` finds between a particle of a and the closed body b.
ParticleScore score_particles(BroadPhase& detector, const SurfaceView& a, const SurfaceView& b);

/// Result and cost of a detector. Times are medians.
struct DetectorScore {
  /// ms; first call of a new detector, split into building its structures and finding the pairs.
  /// For a detector that does not report the split, the query is the whole call.
  double build_ms = 0.0, query_ms = 0.0;
  /// ms; update of the structures in a second call. That call asks for the reversed motion, which
  /// has the same boxes and collisions but is unknown to the detector.
  double refit_ms = 0.0;
  double wall_ms = 0.0;  ///< ms; first call
  std::size_t point_triangle = 0, triangle_point = 0, edge_edge = 0;
  std::size_t missed = 0;  ///< colliding pairs that either call did not report
  double recall = 1.0;     ///< share of the colliding pairs that it reported; 1 if none collide
  std::size_t boxes_missed = 0, beyond_boxes = 0;  ///< relative to the pairs of overlapping boxes
  /// Increase of peak memory over the value before the first call, pairs included, as reported by
  /// the operating system. Where the system does not report it, this is the memory that the
  /// detector says it keeps.
  std::size_t peak_bytes = 0;
  std::optional<ParticleScore> particles{};  ///< of a detector that answers particles
  std::string failure{};                     ///< the broken promise; empty if the detector kept it
};

/// Measures one detector repeatedly, so that the repeats of several detectors can be interleaved.
/// The case and the reference must outlive it.
class DetectorTrial {
 public:
  using Factory = std::function<std::unique_ptr<BroadPhase>()>;
  DetectorTrial(Factory make, const DetectionCase& c, const ReferencePairs& reference);

  /// Creates a new detector and calls it twice. The first time also judges the pairs.
  void measure();
  /// True if more repeats would take too long.
  bool slow() const;
  DetectorScore score() const;

 private:
  void judge(const CandidatePairs& first, const CandidatePairs& second);

  Factory make_;
  const DetectionCase* case_;
  const ReferencePairs* reference_;
  DetectorScore score_;
  std::vector<double> build_ms_, refit_ms_, query_ms_, wall_ms_;
};

/// Result of a narrow phase on the pairs of overlapping boxes.
struct ContactScore {
  std::size_t contacts = 0;
  std::optional<double> first_toi;  ///< empty without contacts or times
  double ms = 0.0;                  ///< median
  std::size_t missed = 0, false_alarms = 0;
};

ContactScore score_contacts(const NarrowPhase& method, const DetectionCase& c,
                            const ReferencePairs& reference, int repeats);

/// Accuracy and time of a narrow phase on queries with known answers.
struct QueryScore {
  std::size_t queries = 0, positives = 0;
  std::size_t misses = 0;                                    ///< collisions that it does not report
  std::size_t false_alarms = 0;                              ///< reports without a collision
  std::optional<std::size_t> first_miss, first_false_alarm;  ///< index of the query

  /// Number of detected collisions whose time is later than the true one; empty for a method that
  /// gives no time. If neighbouring doubles enclose the true time, the later double counts as late.
  std::optional<std::size_t> late_toi;
  std::optional<double> max_toi_error;  ///< largest distance from the enclosure, in steps

  /// Microseconds on one thread; empty if no times were requested.
  std::optional<double> mean_us, median_us, p99_us, max_us;
  std::optional<std::size_t> slowest;  ///< index of the query of max_us
};

/// Fills in missing collision times of the file by ccd_exact. Returns true if any were missing.
bool complete_times(QuerySet& set);

/// Verdicts and times of `method`. The mean covers warm calls with all queries at once. Median, 99
/// % and maximum are over single queries: each is measured in calls with 32 copies of it, and a
/// slow one in calls of its own. Each value is the minimum over `repeats`, which removes clock
/// noise and interruptions. A pass of more than two seconds is made once. With 0 repeats it
/// measures no times. Exceptions of the method propagate.
QueryScore score_queries(const NarrowPhase& method, const QuerySet& set, int repeats);

}  // namespace selvedge
