// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth_pattern.h>

namespace selvedge {

// The patterns register themselves in their own files. A new one adds its name to both lists.
void register_rectangular(ClothPatternRegistry& registry);
void register_triangular(ClothPatternRegistry& registry);
void register_simplified(ClothPatternRegistry& registry);
void register_responsive(ClothPatternRegistry& registry);
void register_arc(ClothPatternRegistry& registry);
void register_bilayered(ClothPatternRegistry& registry);
void register_refined(ClothPatternRegistry& registry);
void register_support(ClothPatternRegistry& registry);
void register_nets(ClothPatternRegistry& registry);
void register_mesh(ClothPatternRegistry& registry);
void register_weave(ClothPatternRegistry& registry);
void register_knit(ClothPatternRegistry& registry);

ClothPatternRegistry cloth_patterns() {
  ClothPatternRegistry registry;
  for (const auto add :
       {register_rectangular, register_triangular, register_simplified, register_responsive,
        register_arc, register_bilayered, register_refined, register_support, register_nets,
        register_mesh, register_weave, register_knit})
    add(registry);
  return registry;
}

}  // namespace selvedge
