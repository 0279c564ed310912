// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/internal/adaptive_cloth.h>
#include <selvedge/simulation/internal/mesh_change.h>

#include <variant>

namespace selvedge {

std::string mesh_change(const Scene& scene) {
  for (const ClothSpec& cloth : scene.cloths)
    if (refine_of(cloth) != nullptr) return fmt::format("cloth \"{}\": \"refine\"", cloth.name);
  for (const SeamSpec& seam : scene.seams)
    if (seam.merge != 0.0) return fmt::format("seam \"{}\": \"merge\"", seam.name);
  return "";
}

Scene with_fixed_mesh(Scene scene) {
  for (ClothSpec& cloth : scene.cloths)
    std::visit([](auto& shape) { shape.refine = {}; }, cloth.shape);
  for (SeamSpec& seam : scene.seams) seam.merge = 0.0;
  return scene;
}

}  // namespace selvedge
