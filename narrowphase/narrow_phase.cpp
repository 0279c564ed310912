// SPDX-License-Identifier: MIT
#include <selvedge/core/parallel.h>
#include <selvedge/narrowphase/detail/contact_geometry.h>
#include <selvedge/narrowphase/narrow_phase.h>

#include <algorithm>
#include <array>

namespace selvedge {
namespace {

using narrowphase_detail::PairVertices;

/// Number of pairs per task, and of queries per call.
constexpr std::size_t kPairGrain = 2048, kQueryBatch = 256;

/// Appends the contacts of the pairs [begin, end) to `out`.
void find_contacts_of(const NarrowPhase& method, const SurfaceView& a, const SurfaceView& b,
                      const CandidatePairs& pairs, std::size_t begin, std::size_t end,
                      std::vector<Contact>& out) {
  std::array<Query, kQueryBatch> queries;
  std::array<double, kQueryBatch> toi;
  for (std::size_t i = begin; i < end; i += kQueryBatch) {
    const std::size_t n = std::min(kQueryBatch, end - i);
    for (std::size_t j = 0; j < n; ++j)
      queries[j] =
          narrowphase_detail::query_of(a, b, narrowphase_detail::pair_at(a, b, pairs, i + j));
    method.find_times(std::span(queries).first(n), std::span(toi).first(n));
    for (std::size_t j = 0; j < n; ++j) {
      if (toi[j] == kNoCollision) continue;
      const PairVertices pair = narrowphase_detail::pair_at(a, b, pairs, i + j);
      Contact& contact = out.emplace_back();
      contact.kind = pair.kind;
      contact.vertex = pair.vertex;
      narrowphase_detail::fill_contact(queries[j], toi[j], contact);
    }
  }
}

}  // namespace

void NarrowPhase::find_contacts(const SurfaceView& a, const SurfaceView& b,
                                const CandidatePairs& pairs, std::vector<Contact>& out) const {
  narrowphase_detail::require_finite(a, "a");
  if (&a != &b) narrowphase_detail::require_finite(b, "b");
  const std::size_t n = pairs.size();
  std::vector<std::vector<Contact>> found((n + kPairGrain - 1) / kPairGrain);
  parallel_for(n, kPairGrain, [&](std::size_t begin, std::size_t end) {
    find_contacts_of(*this, a, b, pairs, begin, end, found[begin / kPairGrain]);
  });
  out.clear();
  for (const std::vector<Contact>& part : found) out.insert(out.end(), part.begin(), part.end());
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
