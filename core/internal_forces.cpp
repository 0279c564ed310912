// SPDX-License-Identifier: MIT
#include <selvedge/core/force.h>

#include <stdexcept>
#include <utility>

namespace selvedge {

// The laws register themselves in their own files. A new one adds its name to both lists. The order
// of the second list is the order in which internal forces add up.
void register_hooke(ForceLawRegistry& registry);
void register_spring_curves(ForceLawRegistry& registry);
void register_membrane(ForceLawRegistry& registry);
void register_yarns(ForceLawRegistry& registry);
void register_shape_operator(ForceLawRegistry& registry);
void register_bending(ForceLawRegistry& registry);
void register_bridson(ForceLawRegistry& registry);
void register_buckling(ForceLawRegistry& registry);
void register_chord(ForceLawRegistry& registry);
void register_bending_curves(ForceLawRegistry& registry);
void register_twisting(ForceLawRegistry& registry);
void register_beam(ForceLawRegistry& registry);
void register_crossings(ForceLawRegistry& registry);
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
  for (const auto add : {register_hooke,
                         register_spring_curves,
                         register_membrane,
                         register_yarns,
                         register_shape_operator,
                         register_bending,
                         register_bridson,
                         register_buckling,
                         register_chord,
                         register_bending_curves,
                         register_twisting,
                         register_beam,
                         register_crossings,
                         register_hysteresis,
                         register_tie,
                         register_plate,
                         register_volume,
                         register_virtual_springs,
                         register_sewing,
                         register_water,
                         register_gravity,
                         register_air})
    add(registry);
  return registry;
}

ForceList make_forces_of(const ForceLawRegistry::Entry& law, const ClothMesh& cloth,
                         const ForceLawOptions& options) {
  const auto given = options.find(law.name());
  return given == options.end() ? law(cloth) : law(given->second, cloth);
}

ForceList make_internal_forces(const ClothMesh& cloth, const ForceLawRegistry& laws,
                               const ForceLawOptions& options) {
  for (const auto& [name, values] : options)
    if (const std::string fault = laws.fault(name); !fault.empty())
      throw std::invalid_argument("force_laws: " + fault);
  ForceList forces;
  for (const auto* law : laws.in_order())
    for (auto& force : make_forces_of(*law, cloth, options)) forces.push_back(std::move(force));
  return forces;
}

}  // namespace selvedge
