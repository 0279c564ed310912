// SPDX-License-Identifier: MIT
#include <selvedge/run/run.h>

#include <cstdio>

int main() {
  selvedge::Scene scene;
  scene.materials["default"] = {.density = 0.15, .bending_stiffness = 2e-5};
  selvedge::ClothSpec& cloth = scene.cloths.emplace_back();
  cloth.shape = selvedge::ClothGrid{.grid = {.cells_x = 30, .cells_y = 30}};
  cloth.placement.translation = {0.0, 0.0, 0.32};
  scene.bodies.emplace_back().shape = selvedge::BodyShape{selvedge::Sphere{.radius = 0.3}};
  selvedge::RunConfig config;
  config.out = "drape_on_sphere";
  const selvedge::RunResult result = selvedge::run_scene(scene, config);
  std::printf("%s after %d steps, stretched by at most %.1f %%\n",
              result.clean ? "clean" : "not clean", result.steps, 100.0 * result.max_stretch);
  return result.clean ? 0 : 1;
}
