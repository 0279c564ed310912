// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/narrowphase/narrow_phase.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace selvedge {

/// One step of two surfaces, or of one against itself: then b is the same view as a.
struct DetectionCase {
  SurfaceView a, b;
  bool self = false;
};

/// What detectors are judged by.
struct ReferencePairs {
  std::string boxes_from;    ///< the detector that found `boxes`
  CandidatePairs boxes;      ///< those whose swept boxes overlap
  CandidatePairs colliding;  ///< of these, those that collide, by ccd_exact
};

/// Box tests that brute force would make.
double brute_force_tests(const DetectionCase& c);
/// So many take about a second.
inline constexpr double kMomentTests = 2e8;
/// By brute force up to so many box tests, else by the tree that reports the same pairs, or, where
/// the tree is what is to be judged, by sorting along an axis.
ReferencePairs reference_pairs(const DetectionCase& c, double most_tests = kMomentTests,
                               const std::string& judged = {});

/// Why a detector cannot serve this case; empty if it can.
std::string why_not(const BroadPhaseTraits& traits, const DetectionCase& c);

/// What a detector found, and at what cost. Times are medians.
struct DetectorScore {
  /// ms of a new detector's first call, for its structures and for finding the pairs; of one that
  /// does not measure, the whole call is the query.
  double build_ms = 0.0, query_ms = 0.0;
  /// ms that a second call takes to bring the structures up to date. It is asked for the motion
  /// backwards: the same boxes and collisions, which it cannot know.
  double refit_ms = 0.0;
  double wall_ms = 0.0;  ///< of the first call
  std::size_t point_triangle = 0, triangle_point = 0, edge_edge = 0;
  std::size_t missed = 0;  ///< colliding pairs that it did not report, in either call
  double recall = 1.0;     ///< share of the colliding pairs that it reported; 1 if there are none
  std::size_t boxes_missed = 0, beyond_boxes = 0;  ///< against the pairs of overlapping boxes
  /// Most memory above that before the first call, pairs included, as the system tells it; where it
  /// does not, what the detector says it keeps.
  std::size_t peak_bytes = 0;
  std::string failure{};  ///< how it broke its promise; empty if it kept it
};

/// Measures one detector again and again, so that the repeats of several can be interleaved. Case
/// and reference must outlive it.
class DetectorTrial {
 public:
  using Factory = std::function<std::unique_ptr<BroadPhase>()>;
  DetectorTrial(Factory make, const DetectionCase& c, const ReferencePairs& reference);

  /// A new detector and two calls. The first time also judges what it finds.
  void measure();
  /// True when more repeats would take too long.
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

/// What a narrow phase found among the pairs of overlapping boxes.
struct ContactScore {
  std::size_t contacts = 0;
  std::optional<double> first_toi;  ///< none without contacts or times
  double ms = 0.0;                  ///< median
  std::size_t missed = 0, false_alarms = 0;
};

ContactScore score_contacts(const NarrowPhase& method, const DetectionCase& c,
                            const ReferencePairs& reference, int repeats);

}  // namespace selvedge
