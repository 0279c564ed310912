// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/idle_proofs.h>
#include <selvedge/scene/scene.h>

#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// What of the detection the motion at hand provably does not need; leaving it out gives the same
/// bits. Parts: "self_collision" (cloth with itself), "body_collision" (cloth with all bodies),
/// "crossings_self" and "crossings_body" (what a state is looked at for after every frame).
///
/// Cloth with itself is idle where every piece is a height field with room between its points
/// (SheetProof) and pieces keep apart by their swept boxes; a body where its swept box keeps apart
/// from that of the cloth. Nothing is left out where the narrow phase may raise false alarms: those
/// are part of its result.
class DetectionPlan {
 public:
  /// Distances in metres: `reach` is the largest gap at which a contact is reported, `margin` how
  /// far particles may end off the motion that candidates are made for, in each coordinate.
  struct Distances {
    double reach = 0.0, margin = 0.0, proximity = 0.0;
  };
  /// `exact`: the narrow phase misses nothing and raises no false alarm.
  DetectionPlan(const Scene& scene, const BuiltScene& built, const Distances& distances,
                bool exact);

  /// Whether no contact of the cloth with itself would be reported, and no two of its primitives
  /// collide on the way. Spans of the cloth's vertices, m.
  bool self_is_idle(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1);
  /// Whether, after that, another end of the same step is as free of collisions.
  bool self_stays_idle(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1);
  /// Whether no body is in reach. `bodies`: all vertices of all bodies, m; `move`: they may be
  /// elsewhere than at the last call.
  bool bodies_are_idle(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1,
                       std::span<const Vec3> bodies_t0, std::span<const Vec3> bodies_t1, bool move);

  /// Whether a state provably has no two primitives of the cloth without a common vertex that
  /// meet, and none that meets a body. Whatever the narrow phase is: crossings are judged exactly.
  bool self_is_uncrossed(std::span<const Vec3> x);
  bool bodies_are_uncrossed(std::span<const Vec3> x, std::span<const Vec3> bodies);

  bool is_on() const { return on_; }
  /// Where the time goes of a part that is not idle, s.
  double& busy_self() { return self_.busy_s; }
  double& busy_bodies() { return bodies_.busy_s; }
  double& busy_crossings_self() { return crossings_self_.busy_s; }
  double& busy_crossings_bodies() { return crossings_bodies_.busy_s; }
  /// By part, since the start.
  std::map<std::string, IdleCount> counts() const;

 private:
  bool sheets_keep_apart(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1, double distance,
                         double between);

  bool proofs_, on_;
  Distances distances_;
  std::vector<std::int32_t> piece_begin_;
  std::vector<SheetProof> sheets_;
  std::vector<SweptBox> boxes_;  // of the pieces, reused
  std::vector<std::int32_t> body_begin_;
  std::vector<SweptBox> body_boxes_;
  ProofBackoff backoff_, crossings_backoff_;
  IdleCount self_, bodies_, crossings_self_, crossings_bodies_;
};

/// One part of a run: whether it runs, and why or why not.
struct PlanItem {
  std::string part;
  enum class Verdict { runs, never, when_needed } verdict = Verdict::runs;
  std::string why;
};

/// What a scene needs, what is never built, and what is left out of a step as long as it is proved
/// to do nothing. For people to read; what is proved is the same as what a run leaves out.
std::vector<PlanItem> plan_scene(const Scene& scene, const BuiltScene& built,
                                 const Methods& methods);

/// A part that can be switched off by hand, at the cost of an error.
struct OptionalPart {
  std::string part;                 ///< "self_collision"
  std::vector<Override> overrides;  ///< what switches it off
};
/// Those that the scene has on.
std::vector<OptionalPart> optional_parts(const Scene& scene);

}  // namespace selvedge
