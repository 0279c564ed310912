// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/build.h>
#include <selvedge/scene/methods.h>

#include <string>
#include <vector>

namespace selvedge {

/// One part of a run: whether it runs, and the reason.
struct PlanItem {
  std::string part;
  enum class Status { runs, never, when_needed } status = Status::runs;
  std::string why;
};

/// Lists the parts that a scene needs, those that are never built, and those that a step leaves out
/// while a proof shows that they would do nothing. A run uses the same proofs.
std::vector<PlanItem> plan_scene(const Scene& scene, const BuiltScene& built,
                                 const Methods& methods);

/// A part that a scene could do without, at the cost of an error.
struct OptionalPart {
  std::string part;                 ///< "self_collision"
  std::vector<Override> overrides;  ///< switch it off
  /// Measured only: a scene file cannot leave it out. "response": colliding pairs are left to the
  /// fail-safe; "frame_check": no frame is searched for crossings.
  bool only_measured = false;
};
/// The optional parts that are on in the scene.
std::vector<OptionalPart> optional_parts(const Scene& scene);

}  // namespace selvedge
