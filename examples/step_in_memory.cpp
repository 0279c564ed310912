// SPDX-License-Identifier: MIT
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/simulation.h>

#include <cstdio>

int main() {
  selvedge::Scene scene;
  scene.materials["default"] = {.density = 0.15, .bending_stiffness = 2e-5};
  selvedge::ClothSpec& cloth = scene.cloths.emplace_back();
  cloth.shape = selvedge::ClothGrid{.grid = {.cells_x = 20, .cells_y = 20}};
  cloth.placement.translation = {0.0, 0.0, 0.32};
  scene.bodies.emplace_back().shape = selvedge::BodyShape{selvedge::Sphere{.radius = 0.3}};
  selvedge::Simulation simulation(scene);
  simulation.advance_to_frame(60);
  std::printf("after %g s the first corner is at a height of %.3f m\n", simulation.time(),
              simulation.positions()[0].z());
}
