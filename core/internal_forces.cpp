// SPDX-License-Identifier: MIT
#include <selvedge/core/force.h>

#include <utility>

namespace selvedge {

// The laws register themselves in their own files. A new one adds its name to both lists. The order
// of the second list is the order in which internal forces add up.
void register_hooke(ForceLawRegistry& registry);
void register_spring_curves(ForceLawRegistry& registry);
void register_shape_operator(ForceLawRegistry& registry);
void register_bending(ForceLawRegistry& registry);
void register_bridson(ForceLawRegistry& registry);
void register_buckling(ForceLawRegistry& registry);
void register_twisting(ForceLawRegistry& registry);
void register_hysteresis(ForceLawRegistry& registry);
void register_tie(ForceLawRegistry& registry);
void register_plate(ForceLawRegistry& registry);
void register_volume(ForceLawRegistry& registry);
void register_virtual_springs(ForceLawRegistry& registry);
void register_sewing(ForceLawRegistry& registry);
void register_water(ForceLawRegistry& registry);
void register_gravity(ForceLawRegistry& registry);
void register_air(ForceLawRegistry& registry);

ForceLawRegistry force_laws() {
  ForceLawRegistry registry;
  for (const auto add :
       {register_hooke, register_spring_curves, register_shape_operator, register_bending,
        register_bridson, register_buckling, register_twisting, register_hysteresis, register_tie,
        register_plate, register_volume, register_virtual_springs, register_sewing, register_water,
        register_gravity, register_air})
    add(registry);
  return registry;
}

ForceList make_internal_forces(const ClothMesh& cloth, const ForceLawRegistry& laws) {
  ForceList forces;
  for (const auto* law : laws.in_order())
    for (auto& force : (*law)(cloth)) forces.push_back(std::move(force));
  return forces;
}

}  // namespace selvedge
