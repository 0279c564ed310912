// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/simulation/contacts/detail/candidates.h>
#include <selvedge/simulation/contacts/detail/clearances.h>
#include <selvedge/simulation/contacts/detail/collisions.h>
#include <selvedge/simulation/contacts/detail/contacts.h>
#include <selvedge/simulation/contacts/detail/crossings.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace selvedge::detail {

/// A motion and the candidates that a search for its collisions uses, for tests and for validation
/// builds. Views; valid until Detection is used again.
struct SearchedMotion {
  std::span<const Vec3> x_t0, x_t1;               ///< m, in the joint index space of ContactPoint
  std::size_t particles = 0;                      ///< how many of them are cloth
  std::span<const Edge> cloth_edges, body_edges;  ///< each counts from 0
  std::span<const Triangle> cloth_triangles, body_triangles;  ///< each counts from 0
  bool self = true;                                           ///< cloth is searched against itself
  bool has_all_pairs = true;                ///< the scene's broad phase promises to miss no pair
  bool finds_all_collisions = true;         ///< so does its narrow phase
  const ExcludedPairs* excluded = nullptr;  ///< null: no pairs are excluded
  const ExcludedSurfaces* excluded_surfaces = nullptr;  ///< null: the scene excludes none
  const CandidatePairs* body_pairs = nullptr;           ///< null: proved to have no collision
  const CandidatePairs* self_pairs = nullptr;           ///< null: proved to have no collision
};

/// The detection of a scene: composes candidates, contacts, collisions, crossings and clearances of
/// one motion. Indices are those of ContactPoint: cloth particles first, then the vertices of all
/// bodies.
class Detection final : public Clearances {
 public:
  /// Adds the time of its phases to `clock`, which must outlive it, as must `built`.
  Detection(const Scene& scene, const BuiltScene& built, const Methods& methods, PhaseClock& clock);
  Detection(const Detection&) = delete;
  Detection& operator=(const Detection&) = delete;

  /// The motion to search, m. The spans must stay alive; their values may change afterwards.
  /// `times`: the bodies are where their motion has them at these times; none: unknown.
  void set_motion(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1, bool bodies_move,
                  const std::optional<StepTimes>& times = {});
  /// Finds the candidate pairs of the present motion. They stay valid for every other x_t1 whose
  /// particles end within the margin of the present one in each coordinate, and some others.
  void find_candidates() { candidates_.find(); }
  /// Whether the candidates still cover the motion.
  bool candidates_cover() const { return candidates_.cover(); }
  /// If they do not, finds those that are due. Returns whether any were.
  bool renew_candidates() { return candidates_.renew(); }
  /// Pairs that candidates leave out from now on; null: no pairs. Must outlive its use.
  void set_excluded(const ExcludedPairs* excluded) { candidates_.set_excluded(excluded); }

  /// Pairs that are nearer at t = 0 than the distance that they have to keep, or would be at the
  /// end.
  void find_proximities(std::vector<ContactPoint>& out);
  /// Pairs that collide during the step, earliest first.
  void find_collisions(std::vector<ContactPoint>& out);

  /// Triangles that cross at t = 0, decided exactly.
  Crossings find_crossings() { return crossings_.find(); }
  /// Counts a state whose crossings need no search, because they are proved to be none.
  void note_uncrossed() { plan_.note_uncrossed(); }
  /// The crossings as edges that pass through triangles of the joint surface, sorted.
  std::vector<EdgeCrossing> find_edge_crossings() { return crossings_.find_edges(); }

  void at_start(std::span<const ContactPoint> hits, std::vector<ContactPoint>& out) override {
    clearances_.at_start(hits, out);
  }
  void all(const Vec3& shift, std::vector<ContactPoint>& out) override {
    clearances_.all(shift, out);
  }

  /// Searches of the cloth with itself by the default broad phase, because that of the scene does
  /// not support them.
  std::int64_t substituted_self_searches() const { return candidates_.substituted_self_searches(); }

  /// Rest gap, m, and friction of the surfaces of two vertices in the joint index space.
  double rest_gap(std::int32_t a, std::int32_t b) const {
    return contacts_.pair_rest_gap({.vertex = {a, a, b, b}, .weight = {}, .normal = {}});
  }
  double friction(std::int32_t a, std::int32_t b) const {
    return contacts_.pair_friction({.vertex = {a, a, b, b}, .weight = {}, .normal = {}});
  }

  JointSurface joint_surface() const { return motion_.joint_surface(); }
  std::span<const Triangle> body_triangles() const { return motion_.body_triangles(); }
  /// First vertex of each body, plus the total; counts from 0.
  std::span<const std::int32_t> body_begin() const { return motion_.body_begin(); }
  std::size_t body_vertices() const { return motion_.body_vertices(); }
  /// The present motion with the candidates that find_collisions used last.
  SearchedMotion searched() const;
  /// By part: how often it was asked for and left out so far, and the time that this saved.
  std::map<std::string, IdleCount> counts() const { return plan_.counts(); }

 private:
  SceneMotion motion_;
  Contacts contacts_;
  Collisions collisions_;
  DetectionPlan plan_;
  SearchContext context_;
  Candidates candidates_;
  std::unique_ptr<BroadPhase> broad_;  // of the clearances
  CrossingSearch crossings_;
  SceneClearances clearances_;
};

}  // namespace selvedge::detail
