// SPDX-License-Identifier: MIT
#include <selvedge/simulation/contacts/detail/detection.h>

namespace selvedge::detail {
namespace {

std::unique_ptr<NarrowPhase> make_narrow_phase(const Scene& scene, const Methods& methods) {
  return make_method(methods.narrow_phases, scene.contact.narrow_phase, "contact.narrow_phase",
                     scene.contact.narrow_phase_options);
}

bool is_exact(const NarrowPhaseTraits& traits) {
  return traits.misses_nothing && traits.no_false_alarm;
}

DetectionPlan::Distances plan_distances(double thickness) {
  return {.reach = kProximityReach * thickness,
          .margin = thickness,
          .proximity = kPointReach * thickness};
}

}  // namespace

Detection::Detection(const Scene& scene, const BuiltScene& built, const Methods& methods,
                     PhaseClock& clock)
    : motion_(built),
      contacts_(scene, built, motion_),
      collisions_(make_narrow_phase(scene, methods)),
      plan_(scene, built, plan_distances(contacts_.largest_rest_gap()),
            is_exact(collisions_.traits())),
      context_{motion_, plan_, clock, contacts_.largest_rest_gap(), searches_self(scene)},
      candidates_(context_, scene, built, methods),
      broad_(selvedge::make_bvh_aabb()),
      crossings_(context_),
      clearances_(context_, candidates_, contacts_, *broad_) {}

void Detection::set_motion(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1, bool bodies_move,
                           const std::optional<StepTimes>& times) {
  motion_.set(x_t0, x_t1, bodies_move);
  candidates_.set_motion(times);
  contacts_.set_step(times ? times->t1 - times->t0 : 0.0);
}

void Detection::find_proximities(std::vector<ContactPoint>& out) {
  contacts_.find_proximities(context_, candidates_, out);
}

void Detection::find_collisions(std::vector<ContactPoint>& out) {
  candidates_.prove_again();
  collisions_.find(context_, candidates_, contacts_, out);
}

SearchedMotion Detection::searched() const {
  const bool has_all_pairs = candidates_.has_all_pairs();
  const ExcludedSurfaces& surfaces = candidates_.excluded_surfaces();
  return {.x_t0 = motion_.x_t0(),
          .x_t1 = motion_.x_t1(),
          .particles = motion_.particles(),
          .cloth_edges = motion_.cloth_edges(),
          .body_edges = motion_.body_edges(),
          .cloth_triangles = motion_.cloth_triangles(),
          .body_triangles = motion_.body_triangles(),
          .self = context_.self,
          .has_all_pairs = has_all_pairs,
          .finds_all_collisions = has_all_pairs && collisions_.traits().misses_nothing,
          .excluded = candidates_.excluded(),
          .excluded_surfaces = surfaces.empty() ? nullptr : &surfaces,
          .body_pairs = candidates_.with_bodies(),
          .self_pairs = candidates_.with_self()};
}

}  // namespace selvedge::detail
