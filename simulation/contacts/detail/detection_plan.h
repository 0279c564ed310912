// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/build.h>
#include <selvedge/simulation/contacts/detail/idle_proofs.h>

#include <map>
#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

/// Proves that parts of the detection find nothing in a motion, so that leaving them out gives the
/// same bits. Parts: "self_collision" (cloth with itself), "body_collision" (cloth with all
/// bodies), "crossings_self" and "crossings_body" (the check of a state after every frame).
///
/// Cloth with itself is idle if every piece is a height field with a distance between its points
/// (SheetProof) and the swept boxes of the pieces keep apart. A body is idle if its swept box keeps
/// apart from that of the cloth. If the narrow phase may raise false alarms, which are part of its
/// result, nothing is left out.
class DetectionPlan {
 public:
  /// Distances in metres. `reach`: largest gap of a reported contact. `margin`: how far, per
  /// coordinate, particles may end from the ends that the candidates were searched for.
  /// `proximity`: largest gap of a reported contact of the cloth with itself.
  struct Distances {
    double reach = 0.0, margin = 0.0, proximity = 0.0;
  };
  /// `exact`: the narrow phase misses nothing and raises no false alarm.
  DetectionPlan(const Scene& scene, const BuiltScene& built, const Distances& distances,
                bool exact);

  /// Whether no contact of the cloth with itself would be reported, and no two of its primitives
  /// collide during the step. Spans of the cloth's vertices, m.
  bool self_is_idle(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1);
  /// Whether, after that, the same step with other ends has no self-collision either.
  bool self_stays_idle(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1);
  /// Whether no body is in reach. `bodies`: all vertices of all bodies, m; `move`: they may have
  /// moved since the last call.
  bool bodies_are_idle(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1,
                       std::span<const Vec3> bodies_t0, std::span<const Vec3> bodies_t1, bool move);

  /// Whether a state provably has no crossing of the cloth with itself, or with a body. Holds for
  /// any narrow phase of the scene, as crossings are decided exactly.
  bool self_is_uncrossed(std::span<const Vec3> x);
  bool bodies_are_uncrossed(std::span<const Vec3> x, std::span<const Vec3> bodies);
  /// Counts a state whose crossings need no search because its steps have proved that it has none.
  void note_uncrossed();

  bool is_on() const { return on_; }
  /// Total seconds spent on each part when it was not idle; the caller adds to them.
  double& busy_self() { return self_.busy_s; }
  double& busy_bodies() { return bodies_.busy_s; }
  double& busy_crossings_self() { return crossings_self_.busy_s; }
  double& busy_crossings_bodies() { return crossings_bodies_.busy_s; }
  /// Counts by part, since the start.
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

}  // namespace selvedge::detail
