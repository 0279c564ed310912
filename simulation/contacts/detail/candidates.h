// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/methods.h>
#include <selvedge/simulation/contacts/detail/body_search.h>
#include <selvedge/simulation/contacts/detail/certificates.h>
#include <selvedge/simulation/contacts/detail/excluded_pairs.h>
#include <selvedge/simulation/contacts/detail/excluded_surfaces.h>
#include <selvedge/simulation/contacts/detail/search_context.h>

#include <memory>
#include <optional>
#include <vector>

namespace selvedge::detail {

/// The broad phase of a scene: candidate pairs of a motion, with a margin. They stay valid while
/// every particle ends, per coordinate, within the margin of the box that encloses its start and
/// the end that the search assumed. Detectors that compare distances, or boxes in the frame of a
/// body, require an end within the margin of the assumed end itself. Pairs of the cloth with itself
/// also stay valid if a common displacement takes all particles out of these boxes.
class Candidates {
 public:
  Candidates(const SearchContext& context, const Scene& scene, const BuiltScene& built,
             const Methods& methods);

  /// Call after the motion of the context has changed. `times`: the bodies are where their motion
  /// has them at these times; none: nothing is known about their positions.
  void set_motion(const std::optional<StepTimes>& times);
  /// Searches for the candidates of the present motion.
  void find();
  /// Whether the candidates cover the present ends.
  bool cover() const { return cover_bodies() && cover_self(); }
  /// Searches for those pairs again, with the bodies or of the cloth with itself, that do not cover
  /// the present ends. Returns whether there were any.
  bool renew();
  /// Repeats for the present ends the proof that the cloth does not meet itself, if `find` relied
  /// on it; searches for candidates if it fails.
  void prove_again();

  /// Null: a proof shows that no contact and no collision exists, and no search was made. Indices
  /// of each surface count from 0.
  const CandidatePairs* with_bodies() const { return bodies_idle_ ? nullptr : &body_pairs_; }
  const CandidatePairs* with_self() const { return self_idle_ ? nullptr : &self_pairs_; }

  /// Contacts of particles with bodies that the broad phase found itself; null: it finds pairs.
  const std::vector<ParticleContact>* particle_contacts() const {
    return answers_particles_ ? &particle_contacts_ : nullptr;
  }
  /// Proofs that candidates do not collide.
  Certificates& certificates() { return certificates_; }

  /// Pairs that candidates leave out from now on; null: no pairs. Must outlive its use.
  void set_excluded(const ExcludedPairs* excluded) { excluded_ = excluded; }
  const ExcludedPairs* excluded() const { return excluded_; }
  const ExcludedSurfaces& excluded_surfaces() const { return excluded_surfaces_; }
  void drop_excluded(CandidatePairs& pairs, bool self) const;

  /// Searches of the cloth with itself by another broad phase than the scene's.
  std::int64_t substituted_self_searches() const { return substituted_self_searches_; }

  /// The scene's broad phase never misses a pair, whatever the bodies are.
  bool has_all_pairs() const { return has_all_pairs_; }

 private:
  double self_inflation() const;
  bool cover_bodies() const;
  bool cover_self() const;
  SurfaceView drifting_view();
  void drop_loose(CandidatePairs& pairs) const;
  void find_with_bodies();
  void find_with_self();
  void search_bodies();
  void search_particles();
  void search_self();

  const SearchContext& context_;
  // m; with bodies, and of the cloth with itself: the least with which all contacts are candidates.
  double margin_, self_margin_;
  std::unique_ptr<BroadPhase> broad_self_;  // the default if the scene's serves bodies only
  bool has_all_pairs_ = true;
  bool answers_particles_ = false;
  bool substitutes_self_ = false;
  std::int64_t substituted_self_searches_ = 0;
  BodySearch body_search_;
  std::vector<char> loose_;     // 1: a particle of no triangle; empty: there are none
  std::vector<Vec3> searched_;  // cloth ends that the pairs with bodies were searched for
  std::vector<Vec3> drifting_;  // those of the pairs with itself, without the displacement that all
                                // particles share
  CandidatePairs body_pairs_, self_pairs_;
  std::vector<ParticleContact> particle_contacts_;
  Certificates certificates_;
  bool bodies_idle_ = false, self_idle_ = false;  // proved, so that those pairs were not searched
  const ExcludedPairs* excluded_ = nullptr;
  ExcludedSurfaces excluded_surfaces_;
};

}  // namespace selvedge::detail
