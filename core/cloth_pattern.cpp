// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth_pattern.h>

#include <stdexcept>
#include <string>

namespace selvedge {

namespace detail {
// Each pattern stands in its own .cpp. To add one, declare it here and put it into the list below.
ClothPattern rectangular_pattern();
ClothPattern triangular_pattern();
ClothPattern simplified_pattern();
ClothPattern checkerboard_pattern();
ClothPattern responsive_pattern();
ClothPattern arc_pattern();
ClothPattern bilayered_pattern();
ClothPattern refine_curved_pattern();
ClothPattern refine_settled_pattern();
ClothPattern support_pattern();
ClothPattern mesh_pattern();
}  // namespace detail

std::vector<ClothPattern> cloth_patterns() {
  using namespace detail;
  return {rectangular_pattern(),  triangular_pattern(),    simplified_pattern(),
          checkerboard_pattern(), responsive_pattern(),    arc_pattern(),
          bilayered_pattern(),    refine_curved_pattern(), refine_settled_pattern(),
          support_pattern(),      mesh_pattern()};
}

ClothPattern cloth_pattern(std::string_view name) {
  std::string known;
  for (const ClothPattern& pattern : cloth_patterns()) {
    if (pattern.make == nullptr) continue;
    if (pattern.name == name) return pattern;
    known += (known.empty() ? "" : ", ") + std::string(pattern.name);
  }
  throw std::invalid_argument("pattern: there is no \"" + std::string(name) + "\"; there are " +
                              known);
}

}  // namespace selvedge
