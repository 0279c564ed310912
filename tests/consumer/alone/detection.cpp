// SPDX-License-Identifier: MIT
#include <selvedge/detection/find.h>

#include <vector>

int main() {
  const std::vector<selvedge::Vec3> high = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  const std::vector<selvedge::Vec3> low = {{0, 0, -1}, {1, 0, -1}, {0, 1, -1}};
  const std::vector<selvedge::Vec3> ground = {{-1, -1, 0}, {3, -1, 0}, {-1, 3, 0}};
  const std::vector<selvedge::Triangle> triangles = {{0, 1, 2}};
  return selvedge::find_collisions({high, low, triangles}, {ground, ground, triangles}).size() == 3
             ? 0
             : 1;
}
