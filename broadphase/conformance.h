// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/broad_phase.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace selvedge {

/// Two generated surfaces that move, stand still, change their triangles, their thickness or their
/// promise to be static over some steps, always in the same arrays. A seed names a scene: no
/// generator of the standard library is in it. Seeds, below 2^59, go through the kinds in turn;
/// every hundredth is large.
class ConformanceScene {
 public:
  explicit ConformanceScene(std::uint64_t seed);
  ~ConformanceScene();

  int step_count() const;
  /// Goes to the next step. The views are those of the present step and must be asked for anew.
  void advance();
  SurfaceView a() const;
  SurfaceView b() const;

  /// What it is, and what the last call of `advance` changed.
  std::string description() const;
  bool b_is_closed() const;      ///< a closed body in every step, triangles outwards
  bool b_keeps_shape() const;    ///< b neither moves nor changes in any step
  bool is_large() const;         ///< a thousand triangles, enough for several threads
  bool is_beyond_float() const;  ///< has coordinates that no float can hold

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Of `boxes`, the pairs whose swept boxes overlap, those that a detector must report even if it
/// culls: the ones that come nearer than the sum of the two thicknesses during the step, or some of
/// them, such as those that collide. For pairs of a surface with itself both views are the same.
using TouchingPairs = std::function<void(const SurfaceView& a, const SurfaceView& b,
                                         const CandidatePairs& boxes, CandidatePairs& touching)>;

struct ConformanceConfig {
  std::uint64_t first_seed = 0;
  std::size_t scenes = 1000;
  /// A detector is kept for so many scenes, then made anew: what it remembers must not harm.
  std::size_t scenes_per_detector = 8;
  /// On every large scene and on every so many others the detector is also run with each number of
  /// `threads`. > 0
  std::size_t scenes_per_thread_check = 25;
  std::vector<int> threads = {1, 2, 8};
  /// By an exact narrow phase; may be empty, but then nothing can be said of what a detector culls.
  TouchingPairs touching;
  /// At most about so many pairs of one call are given to `touching`, evenly from all. > 0
  std::size_t touching_pairs = 300;
};

/// What went wrong first, of one kind.
struct ConformanceFault {
  std::uint64_t seed;
  int step;
  std::string what;  ///< the scene, the call and the pair
};

/// What one detector did. Counts of calls and of pairs.
struct ConformanceReport {
  std::string detector;
  BroadPhaseTraits traits;
  std::size_t scenes = 0;  ///< in which it served at least one call
  std::size_t calls = 0;   ///< answered
  std::size_t refused =
      0;  ///< by std::invalid_argument, where coordinates are beyond float: no fault
  std::uint64_t pairs = 0;  ///< reported

  std::uint64_t boxes = 0;           ///< pairs of brute force in the same calls
  std::uint64_t boxes_found = 0;     ///< of those, reported
  std::uint64_t touching = 0;        ///< pairs that touch, as far as they were looked at
  std::uint64_t touching_found = 0;  ///< of those, reported

  std::uint64_t lost = 0;        ///< pairs that its traits promise and that it did not report
  std::uint64_t beyond = 0;      ///< pairs reported whose boxes do not overlap
  std::uint64_t duplicates = 0;  ///< pairs reported more than once
  std::uint64_t malformed = 0;   ///< pairs that may not stand there: no such index, shared vertex
  std::size_t unsorted = 0;      ///< calls whose lists are not in order
  std::size_t thread_dependent = 0;  ///< calls whose lists depend on the number of threads
  std::size_t failed = 0;            ///< calls that threw
  std::size_t budget_faults = 0;     ///< budgets not kept, or not survived
  std::size_t input_faults = 0;      ///< bad surfaces not refused, or not by name, or not survived
  std::vector<ConformanceFault> faults;  ///< the first of each kind

  /// Nothing above that is a fault for what its traits promise.
  bool passed() const { return faults.empty(); }
  /// Parts of the pairs that were reported; 1 if there were none.
  double box_recall() const;
  double touching_recall() const;
  /// One line of counts, then one for each fault.
  std::string summary() const;
};

/// Runs every detector of `registry` through the same scenes: random and adversarial ones, moving,
/// with itself and with each other, then surfaces that must be refused, then budgets. Brute force
/// is asked once for all. What a detector does not serve by its traits is left out.
std::map<std::string, ConformanceReport> check_conformance(const BroadPhaseRegistry& registry,
                                                           const ConformanceConfig& config = {});

/// The same for one detector, ours or anybody's.
ConformanceReport check_conformance(const std::function<std::unique_ptr<BroadPhase>()>& make,
                                    const ConformanceConfig& config = {});

}  // namespace selvedge
