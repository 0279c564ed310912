// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/broad_phase.h>

namespace selvedge {

BudgetExceeded::BudgetExceeded(std::size_t found, std::size_t limit, const PairBudget& budget)
    : std::runtime_error(
          "broad phase: at least " + std::to_string(found) + " pairs, but the budget of " +
          std::to_string(budget.pairs) + " pairs and " + std::to_string(budget.bytes) +
          " bytes allows " + std::to_string(limit) +
          "; raise it with set_budget, or get the pairs in pieces with stream_pairs"),
      found_(found),
      limit_(limit) {}

std::string promise_of(const BroadPhaseTraits& traits) {
  std::string text = traits.guarantee == Guarantee::conservative ? "conservative: misses nothing"
                                                                 : "approximate: may miss";
  if (traits.particles) text += "; contacts of particles, without pairs";
  if (!traits.self) text += "; no self-collision";
  if (!traits.deforming) text += "; static bodies only";
  if (traits.closed_body_only) text += "; closed bodies only";
  return text;
}

// Each detector registers itself in its own file. A new one adds its name to both lists.
void register_brute_force(BroadPhaseRegistry& registry);
void register_bvh(BroadPhaseRegistry& registry);
void register_curvature_cone(BroadPhaseRegistry& registry);
void register_hash_grid(BroadPhaseRegistry& registry);
void register_minimal_enclosure(BroadPhaseRegistry& registry);
void register_normal_cone(BroadPhaseRegistry& registry);
void register_sweep_and_prune(BroadPhaseRegistry& registry);
void register_uniform_grid(BroadPhaseRegistry& registry);
void register_verlet_list(BroadPhaseRegistry& registry);
void register_voxel(BroadPhaseRegistry& registry);

BroadPhaseRegistry broad_phases() {
  BroadPhaseRegistry registry;
  for (const auto add :
       {register_brute_force, register_bvh, register_curvature_cone, register_hash_grid,
        register_minimal_enclosure, register_normal_cone, register_sweep_and_prune,
        register_uniform_grid, register_verlet_list, register_voxel})
    add(registry);
  registry.add_absent("cgal_aabb_tree", "CGAL");
  registry.add_absent("cgal_box_intersection", "CGAL");
  registry.add_absent("depth_normal_maps", "OSMesa");
  registry.add_absent("embree_collide", "Embree");
  registry.add_absent("fcl_dynamic_aabb_tree", "FCL");
  registry.add_absent("image_space_pairs", "OSMesa");
  return registry;
}

}  // namespace selvedge
