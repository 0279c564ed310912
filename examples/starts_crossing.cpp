// SPDX-License-Identifier: MIT
// A scene that must fail: the cloth crosses the ball at the start. No step could undo the crossing
// without a pass-through. The program rejects the scene with the count, the first pair and a
// remedy.
#include <selvedge/run/run.h>

#include <cstdio>
#include <stdexcept>

int main() {
  selvedge::Scene scene;
  scene.materials["default"] = {};
  scene.cloths.emplace_back().shape = selvedge::ClothGrid{};
  scene.bodies.emplace_back().shape = selvedge::BodyShape{selvedge::Sphere{.radius = 0.3}};
  selvedge::RunConfig config;
  config.out = "starts_crossing";
  try {
    selvedge::run_scene(scene, config);
  } catch (const std::invalid_argument& refusal) {
    std::printf("refused: %s\n", refusal.what());
    return 0;
  }
  std::printf("accepted, although the cloth crosses the ball\n");
  return 1;
}
