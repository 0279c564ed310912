// SPDX-License-Identifier: MIT
//
// What a checkpoint keeps of a simulation.
#pragma once

#include <selvedge/scene/build.h>

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
  int since = 0;       ///< accepted steps since `best` decreased or the way changed
  bool jam = false;    ///< made by a body that left the cloth no room
  bool pinch = false;  ///< a jam of cloth that surfaces of bodies hold between them
  bool is_over() const { return side[0].empty() || side[1].empty(); }
};

/// All tangles of a simulation.
struct Tangles {
  std::vector<Tangle> list;
  /// For each connected part of the joint surface, a vertex of the region that the rest of the
  /// part is brought back to.
  std::vector<std::int32_t> kept;
};

/// A vertex of the cloth that two surfaces of bodies hold between them, because they leave it less
/// than a tenth of its rest gap (detail/pinches.h).
struct Pinch {
  std::int32_t vertex = 0;
  std::array<std::int32_t, 2> triangle{};  ///< of all bodies, on its two sides
  std::array<bool, 2> reversed{};          ///< its normal points away from the vertex
  double share = 0.5;  ///< of the room between them, from the first to the vertex
};

/// Position of a simulation between the ends of two nominal steps.
struct StepControl {
  std::int64_t done = 0;  ///< complete nominal steps; valid only if h > 0
  double h = 0.0;         ///< s, length of the next attempt; 0: at the end of a nominal step
  int halvings = 0;       ///< number of halvings of the planned step that led to `h`
  int span = 1;           ///< nominal steps that the planned step takes at once
};

/// All that a simulation carries from one step to the next. A simulation restored from it continues
/// with the same bits.
struct SimulationState {
  std::int64_t step = 0;      ///< accepted steps so far
  double time = 0.0;          ///< s
  std::vector<Vec3> x, v;     ///< m and m/s, of the cloth vertices
  std::vector<double> water;  ///< kg per cloth vertex; empty if the scene has no water
  StepControl control;
  /// 1/s², of the last step: root mean square by the size of the piece (detail/joined_steps.h);
  /// negative: unknown
  double acceleration = -1.0;
  double still = 0.0;  ///< s, for how long no particle has been faster than time.sleep_speed
  /// Strain that shorter steps could not avoid, by the strain limit (detail/strain_guard.h); 0:
  /// none
  double given_strain = 0.0;
  std::vector<double> memory;          ///< of the integrator and the forces, as they save it
  std::vector<double> contact_memory;  ///< of the response, as it saves it
  std::vector<Pinch> pinches;          ///< by vertex
  Tangles tangles;                     ///< crossings of the start and jams that are not undone yet
  std::vector<SplitEvent> splits;  ///< the splits that led to the present cells of refined pieces
  std::vector<MergeEvent> merges;  ///< the merges that led to the present vertices of seams
  bool refined = false;            ///< at a frame: the changes of the mesh due there have been made
};

/// A state between those before and after a step that changes the mesh.
struct PassedState {
  std::int64_t step = 0;
  std::vector<Vec3> x, v;           ///< m and m/s, of the cloth vertices
  std::vector<std::uint8_t> flags;  ///< bits of VertexFlag, of the cloth vertices
  std::vector<Triangle> triangles;  ///< of the cloth
};

/// FNV-1a over the bytes of positions, velocities and water, as 16 hex digits.
std::string state_hash(const SimulationState& state);

/// What stays of a simulation that has ended.
struct FinalState {
  BuiltScene built;
  SimulationState state;
  std::vector<double> mass;  ///< kg per cloth vertex, water included
};

}  // namespace selvedge
