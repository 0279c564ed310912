// SPDX-License-Identifier: MIT
// A scene that starts with crossings and requests untangling: the sheet passes through the ball.
// Prints how many pairs of triangles crossed, when the last one was free, and which guarantees hold
// at the end.
#include <selvedge/run/run.h>

#include <cstdio>

int main() {
  selvedge::Scene scene;
  scene.materials["default"] = {};
  scene.cloths.emplace_back().shape = selvedge::ClothGrid{"rectangular", {0.6, 0.6, 24, 24}};
  scene.cloths[0].placement.translation = selvedge::Vec3(0.01, 0.02, 0.12);
  scene.bodies.emplace_back().shape = selvedge::BodyShape{selvedge::Sphere{.radius = 0.2}, 32};
  scene.contact.untangle_start = true;
  scene.time.frames = 20;
  selvedge::RunConfig config;
  config.out = "untangles_start";
  const selvedge::RunResult result = selvedge::run_scene(scene, config);
  std::printf(
      "%d pairs crossed at the start; free at %.3f s, at most %.2f m/s; clean from there: %s\n",
      result.tangle.start_pairs, result.tangle.until_s, result.tangle.max_speed,
      result.clean ? "yes" : "no");
  return result.clean ? 0 : 1;
}
