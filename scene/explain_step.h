// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/simulation.h>
#include <selvedge/scene/step_recording.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace selvedge {

/// Who acts on a particle, and with what force, N.
struct Load {
  std::string name;
  double force = 0.0;
};

/// Who is behind a step that failed.
struct Culprit {
  std::string kind;                ///< "squeeze", "push", "carry", "pull", "meet" or "not finite"
  std::string sentence;            ///< readable by a person
  std::vector<std::string> names;  ///< the bodies, handles and pieces of cloth at work
  std::int32_t vertex = -1;        ///< where, joint index
  double motion = 0.0;             ///< m, by which it moves or they near each other in the try
  double room = 0.0;               ///< m, between two that squeeze at the start of the step
  std::vector<Load> loads{};       ///< on that vertex in the last solve
};

/// A colliding pair after one stage of the try.
struct PairStage {
  std::string stage;
  double gap = 0.0;               ///< m, along the normal at the end of the step
  bool collides = false;          ///< on the straight paths there, decided exactly
  std::array<double, 4> moved{};  ///< m, by the stage alone, each vertex
};

/// How a pair that still collides came there.
struct PairExplanation {
  ContactPoint pair;
  std::string name;
  std::vector<PairStage> stages;
  std::string brought_by;  ///< the stage since which it collides
};

struct Explanation {
  double h = 0.0;                      ///< s, length of the try that is explained
  std::vector<Culprit> culprits;       ///< the one that moves most first; at least one
  std::vector<PairExplanation> pairs;  ///< at most kExplainedPairs
  std::size_t colliding_pairs = 0;
};

/// Pairs of which every stage is told.
inline constexpr std::size_t kExplainedPairs = 8;

/// Names who pushed whom in the last failed try of `simulation`, of which `attempt` is the
/// recording. From the particles that collide it follows the contacts, through any number of layers
/// of cloth, to the bodies and handles that move.
Explanation explain_step(const Scene& scene, const Simulation& simulation,
                         const RecordedTry& attempt);

}  // namespace selvedge
