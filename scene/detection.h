// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/clearances.h>
#include <selvedge/scene/body_search.h>
#include <selvedge/scene/contact_filter.h>
#include <selvedge/scene/contact_pairs.h>
#include <selvedge/scene/excluded_pairs.h>
#include <selvedge/scene/joint_surface.h>
#include <selvedge/scene/methods.h>
#include <selvedge/scene/output.h>
#include <selvedge/scene/phase_clock.h>
#include <selvedge/scene/plan.h>
#include <selvedge/scene/scene.h>

#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace selvedge {

/// Two primitives that cross: pairs of triangles without a common vertex that have a common point.
struct Crossings {
  std::vector<std::pair<std::int32_t, std::int32_t>> self;  ///< triangles of the cloth
  std::vector<std::pair<std::int32_t, std::int32_t>>
      body;  ///< triangle of the cloth, of the bodies

  /// How many, and the first; of the bodies if there are any. Not for none.
  std::string sentence() const;
};

/// Throws std::invalid_argument with count, first pair and remedy if the cloth crosses a body or,
/// where `self` asks for it, itself.
void refuse_crossings(const Crossings& found, bool self);

/// Broad and narrow phase of a scene, over the joint index space of ContactPoint: cloth particles
/// first, then the vertices of all bodies.
class Detection final : public Clearances {
 public:
  /// Times its two phases with `clock`, which must outlive it.
  Detection(const Scene& scene, const BuiltScene& built, const Methods& methods, PhaseClock& clock);

  /// The motion to look at; the spans must stay alive and may change in place afterwards.
  /// `times`: those of the bodies' motion, if they are where these say.
  void set_motion(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1, bool bodies_move,
                  const std::optional<StepTimes>& times = {});
  /// Finds the candidate pairs of the present motion; they stay valid for every other x_t1 whose
  /// particles end within the margin of the present one in each coordinate.
  void find_candidates();
  /// True if the candidates still cover the motion; otherwise find_candidates is due.
  bool candidates_cover() const;

  /// Pairs that are nearer at t = 0 than the distance they have to keep, or would be by the end.
  void find_proximities(std::vector<ContactPoint>& out);
  /// Pairs that collide on the way, earliest first.
  void find_collisions(std::vector<ContactPoint>& out);
  void at_start(std::span<const ContactPoint> hits, std::vector<ContactPoint>& out) override;
  void all(const Vec3& shift, std::vector<ContactPoint>& out) override;
  /// Triangles that cross at t = 0, by the exact narrow phase: an edge meets a triangle if and only
  /// if a point that runs along the edge collides with it.
  Crossings find_crossings();
  /// The same as edges that meet triangles, of the joint surface; sorted. Without those of the
  /// cloth with itself where the scene does not want them.
  std::vector<EdgeCrossing> find_edge_crossings();
  /// Pairs that candidates leave out from now on; null: none. Must outlive its use.
  void set_excluded(const ExcludedPairs* excluded) { excluded_ = excluded; }
  JointSurface joint_surface() const;
  /// What was left out so far, and what that saved.
  std::map<std::string, PlanFigures> plan_figures() const;

  std::span<const Triangle> body_triangles() const { return body_triangles_; }
  std::span<const std::int32_t> body_begin() const { return body_begin_; }
  std::size_t body_vertices() const { return surface_.size() - particles_; }

 private:
  double inflation(const BroadPhase& broad) const;
  SurfaceView cloth_view(double inflation) const;
  SurfaceView body_view(double inflation) const;
  ContactPoint joint(const Contact& contact, bool self) const;
  /// The piece and the other surface, as ContactPairs counts them, of a contact.
  std::pair<std::int32_t, std::int32_t> surfaces(const ContactPoint& c) const;
  double thickness(const ContactPoint& c) const;
  double rest_gap(const ContactPoint& c, bool self) const;
  SurfaceView drifting_view();
  void drop_loose(CandidatePairs& pairs) const;
  void drop_excluded(CandidatePairs& pairs, bool self) const;
  void prove_idle();
  void search_bodies();
  void search_self();
  void prove_again();
  void note_covered();
  void find_body_crossings(Crossings& crossings);
  void find_self_crossings(Crossings& crossings);
  void append_proximities(const std::vector<Contact>& found, bool self,
                          std::vector<ContactPoint>& out) const;

  PhaseClock& clock_;
  std::size_t particles_;
  ContactPairs pairs_;
  double thickness_, margin_;  // the largest of all pairs: candidates of none are missed
  bool self_;
  /// The scene's; the default for itself where that one serves bodies alone, and to judge
  /// crossings.
  std::unique_ptr<BroadPhase> broad_self_, broad_crossings_;
  BodySearch body_search_;
  std::unique_ptr<NarrowPhase> narrow_;
  std::unique_ptr<NarrowPhase> exact_;  ///< judges crossings, whatever the scene names

  ContactFilter filter_;
  std::vector<Edge> cloth_edges_, body_edges_;
  std::vector<Triangle> cloth_triangles_, body_triangles_;
  std::vector<std::int32_t> body_begin_;  // first vertex of each body, plus the total
  std::vector<Vec3> rest_;                // cloth at the start
  std::vector<char> loose_;               // particles of no triangle; empty: there are none
  std::vector<std::int32_t> surface_;     // of each joint vertex, as ContactPairs counts

  std::span<const Vec3> x_t0_, x_t1_;
  std::uint64_t body_id_ = 1;
  bool bodies_moved_ = true;
  std::vector<Vec3> covered_;   // cloth x_t1 that the candidates were made for
  std::vector<Vec3> drifting_;  // cloth x_t1 without the motion that all particles share
  CandidatePairs body_pairs_, self_pairs_;
  DetectionPlan plan_;
  bool bodies_idle_ = false, self_idle_ = false;  // proved, so that those pairs were not looked for
  const ExcludedPairs* excluded_ = nullptr;
  std::vector<Contact> found_;
};

}  // namespace selvedge
