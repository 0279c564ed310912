// SPDX-License-Identifier: MIT
#include <selvedge/response/fail_safe.h>

namespace selvedge {

// Each fail-safe registers itself in its own file. A new one adds its name to both lists.
void register_displacement_bound(FailSafeRegistry& registry);
void register_impulse_zones(FailSafeRegistry& registry);
void register_layered(FailSafeRegistry& registry);
void register_projection_zones(FailSafeRegistry& registry);
void register_separating_planes(FailSafeRegistry& registry);

FailSafeRegistry fail_safes() {
  FailSafeRegistry registry;
  for (const auto add : {register_displacement_bound, register_impulse_zones, register_layered,
                         register_projection_zones, register_separating_planes})
    add(registry);
  return registry;
}

}  // namespace selvedge
