// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace selvedge {

/// Two generated surfaces that, over some steps, move, rest, or change their triangles, their
/// thickness or their static_id, always in the same arrays. A seed identifies a scene on every
/// platform: no generator of the standard library is used. Seeds, below 2^59, cycle through the
/// kinds of scenes; every hundredth scene is large.
class ConformanceScene {
 public:
  explicit ConformanceScene(std::uint64_t seed);
  ~ConformanceScene();

  /// Number of steps of the scene.
  int step_count() const;
  /// Advances to the next step. Views obtained earlier are invalid afterwards.
  void advance();
  /// The two surfaces in the current step.
  SurfaceView a() const;
  SurfaceView b() const;

  /// Describes the scene and the changes of the last call of `advance`.
  std::string description() const;
  bool b_is_closed() const;      ///< b is a closed body in every step, triangles oriented outwards
  bool b_keeps_shape() const;    ///< b neither moves nor changes in any step
  bool is_large() const;         ///< has about a thousand triangles, enough for several threads
  bool is_beyond_float() const;  ///< has coordinates outside the range of float

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Given the pairs `boxes` whose swept boxes overlap, returns pairs that a detector must report
/// even if it culls: all pairs that come nearer than the sum of the two thicknesses during the
/// step, or a subset, such as those that collide. For pairs of a surface with itself both views are
/// the same.
using TouchingPairs = std::function<void(const SurfaceView& a, const SurfaceView& b,
                                         const CandidatePairs& boxes, CandidatePairs& touching)>;

/// Options of check_conformance.
struct ConformanceConfig {
  std::uint64_t first_seed = 0;
  std::size_t scenes = 1000;
  /// Number of scenes for which a detector is kept before it is created anew, to test that kept
  /// data does no harm.
  std::size_t scenes_per_detector = 8;
  /// Every large scene and every so many other scenes are repeated with each number of `threads`. >
  /// 0
  std::size_t scenes_per_thread_check = 25;
  std::vector<int> threads = {1, 2, 8};
  /// An exact narrow phase; may be empty, but then the pairs that a detector culls are not checked.
  TouchingPairs touching = {};
  /// Maximum number of pairs per call passed to `touching`, evenly chosen. > 0
  std::size_t touching_pairs = 300;
};

/// The first fault of one kind.
struct ConformanceFault {
  std::uint64_t seed;
  int step;
  std::string what;  ///< scene, call and pair
};

/// Results of one detector. Counts calls and pairs.
struct ConformanceReport {
  std::string detector;
  BroadPhaseTraits traits;
  std::size_t scenes = 0;   ///< scenes in which it supported at least one call
  std::size_t calls = 0;    ///< calls answered
  std::size_t refused = 0;  ///< calls rejected with std::invalid_argument because coordinates
                            ///< exceed float: not a fault
  std::uint64_t pairs = 0;  ///< pairs reported

  std::uint64_t boxes = 0;           ///< pairs of brute force in the same calls
  std::uint64_t boxes_found = 0;     ///< pairs of brute force that it reported
  std::uint64_t touching = 0;        ///< pairs that touch, among those checked
  std::uint64_t touching_found = 0;  ///< touching pairs that it reported

  std::uint64_t lost = 0;            ///< pairs that its traits guarantee but that it did not report
  std::uint64_t beyond = 0;          ///< pairs reported although their boxes do not overlap
  std::uint64_t duplicates = 0;      ///< pairs reported more than once
  std::uint64_t malformed = 0;       ///< invalid pairs: index out of range, or shared vertex
  std::size_t unsorted = 0;          ///< calls whose lists are not sorted
  std::size_t thread_dependent = 0;  ///< calls whose lists depend on the number of threads
  std::size_t failed = 0;            ///< calls that threw
  std::size_t budget_faults = 0;     ///< budgets that were exceeded, or after which the detector
                                     ///< failed
  std::size_t input_faults = 0;  ///< invalid surfaces that were accepted, rejected without naming
                                 ///< the fault, or after which the detector failed
  std::vector<ConformanceFault> faults;  ///< the first of each kind

  /// True if no count above is a fault under the detector's traits.
  bool passed() const { return faults.empty(); }
  /// Fractions of the pairs that were reported; 1 if there were none.
  double box_recall() const;
  double touching_recall() const;
  /// One line of counts, then one line for each fault.
  std::string summary() const;
};

/// Runs every detector of `registry` through the same scenes: random and adversarial surfaces,
/// moving, with themselves and with each other; then surfaces that must be rejected; then budgets.
/// Brute force runs once for all detectors. Calls that a detector's traits exclude are skipped.
std::map<std::string, ConformanceReport> check_conformance(const BroadPhaseRegistry& registry,
                                                           const ConformanceConfig& config = {});

/// The same for a single detector, for example one of your own.
ConformanceReport check_conformance(const std::function<std::unique_ptr<BroadPhase>()>& make,
                                    const ConformanceConfig& config = {});

}  // namespace selvedge
