// SPDX-License-Identifier: MIT
#include <selvedge/scene/build.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

int main() {
  selvedge::Scene scene;
  scene.materials["default"] = {.density = 0.15};
  selvedge::ClothSpec& cloth = scene.cloths.emplace_back();
  cloth.shape = selvedge::ClothGrid{.grid = {.cells_x = 4, .cells_y = 4}};
  selvedge::Simulation simulation(scene, selvedge::build_scene(scene));
  return simulation.step_towards(1) && simulation.state().time > 0.0 ? 0 : 1;
}
