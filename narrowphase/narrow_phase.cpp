// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/detail/pair_batches.h>
#include <selvedge/narrowphase/narrow_phase.h>

namespace selvedge {
void NarrowPhase::find_contacts(const SurfaceView& a, const SurfaceView& b,
                                const CandidatePairs& pairs, std::vector<Contact>& out) const {
  detail::require_finite(a, "a");
  if (&a != &b) detail::require_finite(b, "b");
  const detail::SurfacePairs in{a, b, pairs};
  detail::find_contacts_among(
      in,
      [&](std::size_t begin, std::size_t, const auto& add) -> std::size_t {
        add(detail::pair_at(a, b, pairs, begin));
        return 1;
      },
      [&](std::span<const Query> queries, std::span<double> toi) { find_times(queries, toi); },
      out);
}

bool NarrowPhase::collides(const Query& query, double& toi) const {
  double time = kNoCollision;
  find_times({&query, 1}, {&time, 1});
  if (time == kNoCollision) return false;
  toi = time;
  return true;
}

std::string promise_of(const NarrowPhaseTraits& traits) {
  return std::string(traits.misses_nothing ? "misses nothing" : "may miss") +
         (traits.no_false_alarm ? ", no false alarm" : ", may raise false alarms") +
         (traits.gives_time ? "" : ", gives no time") +
         (traits.limits.empty() ? "" : "; " + traits.limits);
}

// Each method registers itself in its own file. A new one adds its name to both lists.
void register_ccd_additive(NarrowPhaseRegistry& registry);
void register_ccd_cubic(NarrowPhaseRegistry& registry);
void register_ccd_cubic_bridson(NarrowPhaseRegistry& registry);
void register_ccd_cubic_provot(NarrowPhaseRegistry& registry);
void register_ccd_exact(NarrowPhaseRegistry& registry);
void register_ccd_inclusion(NarrowPhaseRegistry& registry);
void register_ccd_root_parity(NarrowPhaseRegistry& registry);
void register_centroid_velocity(NarrowPhaseRegistry& registry);
void register_plane_crossing(NarrowPhaseRegistry& registry);
void register_proximity(NarrowPhaseRegistry& registry);

NarrowPhaseRegistry narrow_phases() {
  NarrowPhaseRegistry registry;
  for (const auto add : {register_ccd_additive, register_ccd_cubic, register_ccd_cubic_bridson,
                         register_ccd_cubic_provot, register_ccd_exact, register_ccd_inclusion,
                         register_ccd_root_parity, register_centroid_velocity,
                         register_plane_crossing, register_proximity})
    add(registry);
  registry.add_absent("fcl_vertex_face_edge_edge", "FCL");
  registry.add_absent("libccd_gjk", "libccd");
  registry.add_absent("libccd_mpr", "libccd");
  return registry;
}

}  // namespace selvedge
