// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/measure.h>

#include <vector>

int main() {
  const std::vector<selvedge::Vec3> x = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<selvedge::Triangle> triangles = {{0, 1, 2}};
  return selvedge::surface_area(x, triangles) == 0.5 ? 0 : 1;
}
