// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>

#include <string>
#include <vector>

namespace selvedge {

/// Two jaws that close on a hanging piece of cloth, of random size, gap, offset and tilt.
enum class GripKind {
  held,    ///< a strip whose top row is held between the jaws, which leave it some room
  closed,  ///< jaws that close completely on a strip, which hangs from them and is freed again
  towel,   ///< the same with a wide piece of cloth
  shears   ///< a short jaw that closes on a tall one, and moves along it with the greater friction
};
inline constexpr int kGripKinds = 4;
const char* grip_name(GripKind kind);

struct GripScene {
  Scene scene;
  std::string text;  ///< the random parameters in words
  GripKind kind = GripKind::held;
  double rest_gap = 0.0;
  double closed = 0.0, released = 0.0, parts = 0.0;  ///< s: jaws closed, handle let go, jaws part
  double end = 0.0;                                  ///< s
  std::vector<BodySpec> jaws;  ///< the two, also where they belong to one body
  int leads = 0;               ///< the jaw with the greater friction; -1: both alike
  bool one_body = false;       ///< both belong to one body, whose vertices a program sets
};
GripScene make_grip(GripKind kind, bool one_body, unsigned seed);

struct GripOutcome {
  double stretch = 0.0;  ///< the largest of any accepted state
  double bent = 0.0;     ///< m, of held cloth: the largest distance from the plane that it hangs in
  double slipped = 0.0;  ///< m, largest distance of a vertex from where the jaws take it, from the
                         ///< time when the handle lets go until the jaws part
  double freed = 0.0;    ///< largest speed of a vertex in the state that frees it, by that of the
                         ///< jaws at that time
  int pinched = 0;       ///< vertices that are pinched when the handle lets go
  double fallen = 0.0;   ///< m, least fall of a vertex after the jaws have parted
  std::string stopped;
  RunResult result;
};
GripOutcome grip(const GripScene& scene);
/// What is wrong with it; empty if nothing is.
std::string grip_fault(const GripScene& scene, const GripOutcome& outcome);

}  // namespace selvedge
