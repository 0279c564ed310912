// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/broadphase/minimal_enclosure.h>
#include <selvedge/broadphase/verlet_list.h>

namespace selvedge {

BudgetExceeded::BudgetExceeded(std::size_t found, std::size_t limit, const PairBudget& budget)
    : std::runtime_error("broad phase: at least " + std::to_string(found) +
                         " pairs, but the budget of " + std::to_string(budget.pairs) +
                         " pairs and " + std::to_string(budget.bytes) + " bytes has room for " +
                         std::to_string(limit) +
                         "; raise it by set_budget, or take the pairs in pieces by stream_pairs"),
      found_(found),
      limit_(limit) {}

BroadPhaseRegistry broad_phases() {
  return {{"brute_force", [] { return make_brute_force(); }},
          {"bvh_aabb", [] { return make_bvh_aabb(); }},
          {"bvh_kdop6", [] { return make_bvh_kdop(6); }},
          {"bvh_kdop14", [] { return make_bvh_kdop(14); }},
          {"bvh_kdop18", [] { return make_bvh_kdop(18); }},
          {"bvh_kdop26", [] { return make_bvh_kdop(26); }},
          {"bvh_obb", [] { return make_bvh_obb(); }},
          {"curvature_cone", [] { return make_curvature_cone(); }},
          {"hash_grid", [] { return make_hash_grid(); }},
          {"minimal_enclosure", [] { return make_minimal_enclosure(); }},
          {"sweep_and_prune", [] { return make_sweep_and_prune(); }},
          {"uniform_grid", [] { return make_uniform_grid(); }},
          {"verlet_bvh", [] { return make_verlet_list(make_bvh_aabb()); }},
          {"voxel", [] { return make_voxel(); }}};
}

}  // namespace selvedge
