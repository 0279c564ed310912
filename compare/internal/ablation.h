// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/compare/compare_table.h>
#include <selvedge/scene/methods.h>
#include <selvedge/simulation/internal/plan.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// Verdict on the mean of paired differences, from a t-test against each end of ±tolerance.
enum class EquivalenceVerdict {
  equivalent,  ///< the mean is within ±tolerance, with 95 % confidence
  different,   ///< the mean is outside, with 95 % confidence
  undecided,   ///< neither is shown; more seeds are needed
};

struct Equivalence {
  EquivalenceVerdict verdict = EquivalenceVerdict::undecided;
  double mean = 0.0;
  double low = 0.0, high = 0.0;  ///< one-sided 95 % bounds; together the 90 % interval
};

/// Two one-sided tests [Schuirmann1987] at the level of 5 % each, for independent differences with
/// an approximately normal distribution. Returns `undecided` for fewer than two values. If all
/// values are equal, their common value decides without a test.
Equivalence test_equivalence(std::span<const double> differences, double tolerance);

/// Student's t with an exceedance probability of 5 %, for `freedom` >= 1 degrees of freedom.
double student_95(std::size_t freedom);

/// Result of one run of a scene in this process. The time is that of the processor and covers the
/// steps and the check of every frame. It excludes reading, building and writing.
struct TimedRun {
  double seconds = 0.0;
  RunResult result;
  ClothEnds cloth;
  std::string fault;  ///< why the run stopped early; empty if it finished
};
struct TimedRunConfig {
  std::uint32_t seed = 0;    ///< 0 keeps the scene; any other seed perturbs its start (kSeedSpeed)
  bool check_frames = true;  ///< false: the end alone is checked, outside the time
  double longest = std::numeric_limits<double>::infinity();  ///< s; a longer run stops with a fault
};
TimedRun run_timed(Scene scene, const Methods& methods, const TimedRunConfig& config = {});

/// Measures that an optional part must not change, however the cloth folds: mean position and
/// extents of the cloth over its extent at the start, root mean square strain of its edges, and the
/// mean angle between neighbouring triangles over π. The map holds them by name; all are
/// dimensionless.
std::map<std::string, double> shape_measures(const ClothEnds& cloth);

/// Comparison of the scene without one part with the complete scene, over all seeds.
struct AblationRow {
  std::string part;
  bool clean = true;           ///< every run finished without a crossing
  std::string why;             ///< the first fault, if `clean` is false
  bool only_measured = false;  ///< a scene file cannot leave it out
  int crossings = 0;           ///< most pairs of triangles that cross in a frame of any run
  bool same_bits = false;      ///< every run ended in the bits of the complete scene
  /// The measure whose interval reaches farthest. The part may be removed only if all measures are
  /// equivalent; this rule needs no correction for the number of measures [Berger1982].
  std::string worst;
  Equivalence equivalence;
  double distance = 0.0;  ///< between end positions, same seed; mean over seeds, over the extent
  double spread = 0.0;    ///< the same between neighbouring seeds with all parts on
  Quartiles time_ratio;   ///< time without the part over time with it, same seed

  /// True if the runs are clean and the measures are proved equivalent within the tolerance.
  bool could_go() const { return clean && equivalence.verdict == EquivalenceVerdict::equivalent; }
  /// True if the time saved exceeds twice the noise of the ratio.
  bool saves_time() const;
  /// One of "needed", "could go", "could go, and saves nothing that shows", "not decided".
  std::string verdict() const;
};

struct AblationConfig {
  int seeds = 5;            ///< runs of each variant; fewer than 2 decide nothing
  double tolerance = 0.01;  ///< for every measure
  double patience = 4.0;    ///< longest time of a variant over that of the complete scene
};

/// Runs the complete scene and the scene without each of its optional parts, seed by seed. Throws
/// std::runtime_error if the complete scene does not finish.
std::vector<AblationRow> ablate(const std::filesystem::path& scene,
                                const std::vector<Override>& overrides, const Methods& methods,
                                const AblationConfig& config);

}  // namespace selvedge
