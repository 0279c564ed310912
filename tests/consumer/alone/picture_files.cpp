// SPDX-License-Identifier: MIT
#include <selvedge/pictures/picture_files.h>
#include <selvedge/pictures/renderer/render.h>

#include <vector>

int main() {
  const std::vector<selvedge::Vec3> x = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<selvedge::Triangle> triangles = {{0, 1, 2}};
  const std::vector<selvedge::RenderSurface> surfaces = {{.x = x, .triangles = triangles}};
  selvedge::write_png("alone_picture_files.png",
                      selvedge::render({.width = 32, .height = 24}, surfaces));
}
