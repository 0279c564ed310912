// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>

#include <string>

namespace selvedge {

/// Kind of crossings at the start of a generated scene.
enum class TangleKind { bump, layers, sleeve, corner };
inline constexpr int kTangleKinds = 4;
const char* tangle_name(TangleKind kind);

/// A scene that starts with a tangle of random size, depth and angle.
struct TangledScene {
  Scene scene;
  BuiltScene built;
  std::string text;  ///< the random parameters in words
};
TangledScene make_tangle(TangleKind kind, unsigned seed);

/// Result of a tangled scene, by the simulation and by the judge, which shares no code with it.
struct TangleOutcome {
  int start_pairs = 0, pairs = 0;
  double until_s = -1.0;
  int steps = 0;             ///< accepted steps until then
  double max_apart = 0.0;    ///< m/s, like max_speed, relative to the mean of the falling cloth
  double max_speed = 0.0;    ///< m/s, largest displacement over time of any particle
  bool only_shrinks = true;  ///< no pair became excluded that had not been before
  /// Crossings and collisions on paths that do not belong to a tangle.
  std::size_t elsewhere = 0;
  std::size_t after = 0;  ///< crossings and collisions of any kind after the tangle is free
  std::string stopped;
  std::string hash;
  RunResult result;
};
/// Runs until the tangle is free and for `frames_after` more frames, at most `frames` in all.
TangleOutcome untangle(TangledScene tangled, int frames, int frames_after, bool with_judge = true);

}  // namespace selvedge
