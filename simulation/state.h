// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace selvedge {

/// A tangle that is being undone: the parts of its two sheets that may pass through each other,
/// and the state of the search for a way out.
struct Tangle {
  std::array<std::vector<std::int32_t>, 2> side;  ///< joint triangles, sorted
  int way = 0;                                    ///< the way that is in use
  int best = 0;                                   ///< fewest crossings so far
  int since = 0;  ///< accepted steps since `best` decreased or the way changed
  bool is_over() const { return side[0].empty() || side[1].empty(); }
};

/// All tangles of a simulation.
struct Tangles {
  std::vector<Tangle> list;
  /// For each connected part of the joint surface, a vertex of the region that the rest of the
  /// part is brought back to.
  std::vector<std::int32_t> kept;
};

/// The tangles that a run started with; all 0 for a run that started clean.
struct TangleReport {
  int start_pairs = 0;     ///< triangle pairs that crossed at the start
  int pairs = 0;           ///< of them, that cross now
  int elsewhere = 0;       ///< most pairs that crossed at one time outside of the tangles
  double until_s = 0.0;    ///< time from which no tangle is left; -1: one is left
  double max_speed = 0.0;  ///< m/s, fastest particle in any accepted state until then
  bool given_up = false;   ///< a tangle could not be resolved
};

/// Position of a simulation between the ends of two nominal steps.
struct StepControl {
  std::int64_t done = 0;  ///< complete nominal steps; valid only if h > 0
  double h = 0.0;         ///< s, length of the next attempt; 0: at the end of a nominal step
  int halvings = 0;       ///< number of halvings of the nominal step that led to `h`
};

/// All that a simulation carries from one step to the next. A simulation restored from it continues
/// with the same bits.
struct SimulationState {
  std::int64_t step = 0;      ///< accepted steps so far
  double time = 0.0;          ///< s
  std::vector<Vec3> x, v;     ///< m and m/s, of the cloth vertices
  std::vector<double> water;  ///< kg per cloth vertex; empty if the scene has no water
  StepControl control;
  std::vector<double> memory;      ///< of the integrator and the forces, as they save it
  Tangles tangles;                 ///< crossings of the start that are not undone yet
  std::vector<SplitEvent> splits;  ///< the splits that led to the present cells of refined pieces
};

/// FNV-1a over the bytes of positions, velocities and water, as 16 hex digits.
std::string state_hash(const SimulationState& state);

}  // namespace selvedge
