// SPDX-License-Identifier: MIT
#include <selvedge/core/parallel.h>
#include <selvedge/narrowphase/ccd_exact.h>
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/detail/contact_geometry.h>
#include <selvedge/narrowphase/narrow_phase.h>

#include <algorithm>
#include <array>

namespace selvedge {
namespace {

using narrowphase_detail::PairVertices;

/// Pairs that one task handles, and queries that are gathered for one call.
constexpr std::size_t kGrain = 2048, kBatch = 256;

/// Contacts of the pairs [begin, end), appended to `out`.
void find_contacts_of(const NarrowPhase& method, const SurfaceView& a, const SurfaceView& b,
                      const CandidatePairs& pairs, std::size_t begin, std::size_t end,
                      std::vector<Contact>& out) {
  std::array<Query, kBatch> queries;
  std::array<double, kBatch> toi;
  for (std::size_t i = begin; i < end; i += kBatch) {
    const std::size_t n = std::min(kBatch, end - i);
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
  std::vector<std::vector<Contact>> found((n + kGrain - 1) / kGrain);
  parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
    find_contacts_of(*this, a, b, pairs, begin, end, found[begin / kGrain]);
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

NarrowPhaseRegistry narrow_phases() {
  NarrowPhaseRegistry registry;
  registry["ccd_additive"] = [](const NarrowPhaseConfig& c) { return make_ccd_additive(c); };
  registry["ccd_cubic"] = make_ccd_cubic;
  registry["ccd_cubic_bridson"] = make_ccd_cubic_bridson;
  registry["ccd_cubic_provot"] = make_ccd_cubic_provot;
  registry["ccd_exact"] = [](const NarrowPhaseConfig& c) {
    return c.min_separation == 0.0 ? make_ccd_exact() : make_ccd_separation(c.min_separation);
  };
  registry["ccd_inclusion"] = [](const NarrowPhaseConfig& c) { return make_ccd_inclusion(c); };
  registry["ccd_root_parity"] = make_ccd_root_parity;
  registry["centroid_velocity"] = make_centroid_velocity;
  registry["plane_crossing"] = make_plane_crossing;
  registry["proximity"] = make_proximity;
  return registry;
}

}  // namespace selvedge
