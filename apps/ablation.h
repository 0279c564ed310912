// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/compare_error.h>
#include <selvedge/apps/compare_table.h>
#include <selvedge/apps/equivalence.h>
#include <selvedge/scene/methods.h>
#include <selvedge/scene/plan.h>
#include <selvedge/scene/simulation.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace selvedge {

/// A run of a scene in this process. What is timed is steps and the check of every frame, which
/// every run makes; nothing is read, built or written meanwhile.
struct TimedRun {
  double seconds = 0.0;
  RunResult result;
  ClothEnds cloth;
  std::string fault;  ///< why it did not come to its end; empty: it did
};
/// `seed` 0: as the scene is; others: every particle starts with a random velocity of up to
/// kSeedSpeed in each coordinate, so that what is chaotic takes another course.
TimedRun run_timed(const Scene& scene, const Methods& methods, std::uint32_t seed = 0);

/// A breath, m/s: a thousandth of what the cloth reaches.
inline constexpr double kSeedSpeed = 1e-3;

/// What a part may not change, whichever folds the cloth falls into: mean position and extents of
/// the cloth over its extent at the start, root mean square strain of its edges, and the mean angle
/// between neighbouring triangles over π. By name, all without unit.
std::map<std::string, double> shape_measures(const ClothEnds& cloth);

/// What became of the scene without one part, over all seeds.
struct AblationRow {
  std::string part;
  bool clean = true;  ///< every run came to its end without a crossing
  std::string why;    ///< the first fault, where not
  /// Of the measures, the one whose interval reaches farthest; the part may go only if all of them
  /// are equivalent, which needs no correction for their number [Berger1982].
  std::string worst;
  Equivalence equivalence;
  double distance = 0.0;  ///< of the particles' ends, same seed, mean over seeds, over the extent
  double spread = 0.0;    ///< the same between neighbouring seeds, nothing left out
  Quartiles time_ratio;   ///< time without over time with the part, same seed

  /// Proved within the tolerance, and clean.
  bool could_go() const { return clean && equivalence.verdict == EquivalenceVerdict::equivalent; }
  /// The time saved is above twice the noise of the ratio.
  bool saves_time() const;
  /// "needed", "could go", "could go, and saves nothing that shows", "not decided".
  std::string verdict() const;
};

struct AblationConfig {
  int seeds = 5;            ///< runs of each; fewer than 2 decide nothing
  double tolerance = 0.01;  ///< of every measure
};

/// Runs the scene as it is and without each of its optional parts, seed by seed. Throws
/// std::runtime_error if it does not come to its end as it is.
std::vector<AblationRow> ablate(const std::filesystem::path& scene,
                                const std::vector<Override>& overrides, const Methods& methods,
                                const AblationConfig& config);

}  // namespace selvedge
