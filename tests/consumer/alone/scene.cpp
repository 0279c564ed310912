// SPDX-License-Identifier: MIT
#include <selvedge/scene/build.h>

int main() {
  selvedge::Scene scene;
  scene.materials["default"] = {.density = 0.15};
  scene.cloths.emplace_back().shape = selvedge::ClothGrid{.grid = {.cells_x = 4, .cells_y = 4}};
  return selvedge::build_scene(scene).cloth.surface.vertices.size() == 25 ? 0 : 1;
}
