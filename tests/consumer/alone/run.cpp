// SPDX-License-Identifier: MIT
#include <selvedge/run/run.h>

int main() {
  selvedge::Scene scene;
  scene.materials["default"] = {.density = 0.15};
  selvedge::ClothSpec& cloth = scene.cloths.emplace_back();
  cloth.shape = selvedge::ClothGrid{.grid = {.cells_x = 4, .cells_y = 4}};
  selvedge::RunConfig config;
  config.out = "result_of_run";
  config.max_steps = 1;
  return selvedge::run_scene(scene, config).steps == 1 ? 0 : 1;
}
