// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/simulation.h>

#include <string>

namespace selvedge {

/// What crosses at the start of a generated scene.
enum class TangleKind { bump, layers, sleeve, corner };
inline constexpr int kTangleKinds = 4;
const char* tangle_name(TangleKind kind);

/// A scene that starts tangled, of random size, depth and angle.
struct TangledScene {
  Scene scene;
  BuiltScene built;
  std::string text;  ///< what was drawn
};
TangledScene make_tangle(TangleKind kind, unsigned seed);

/// What became of it, by the simulation and by the judge, which shares no code with it.
struct TangleOutcome {
  int start_pairs = 0, pairs = 0;
  double until_s = -1.0;
  int steps = 0;             ///< accepted until then
  double max_apart = 0.0;    ///< m/s, as max_speed, against the mean of the cloth, which falls
  double max_speed = 0.0;    ///< m/s, largest displacement over time of any particle
  bool only_shrinks = true;  ///< no pair was excluded that had not been
  /// Crossings and collisions on paths that do not belong to a tangle.
  std::size_t elsewhere = 0;
  std::size_t after = 0;  ///< the same of any kind, once it was over
  std::string stopped;
  std::string hash;
  RunResult result;
};
/// Runs to the end of the tangle and `frames_after` frames on, at most `frames`.
TangleOutcome untangle(TangledScene tangled, int frames, int frames_after, bool with_judge = true);

}  // namespace selvedge
