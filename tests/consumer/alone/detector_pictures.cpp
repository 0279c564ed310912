// SPDX-License-Identifier: MIT
#include <selvedge/pictures/detector_pictures.h>

#include <vector>

int main() {
  const std::vector<selvedge::Vec3> x = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<selvedge::Triangle> triangles = {{0, 1, 2}};
  const std::vector<selvedge::Edge> edges = {{0, 1}, {0, 2}, {1, 2}};
  selvedge::Camera camera;
  camera.width = camera.height = 32;
  return selvedge::level_pictures({x, x, edges, triangles}, camera).empty() ? 1 : 0;
}
