// SPDX-License-Identifier: MIT
#include <selvedge/detection/find.h>

#include <cstdio>
#include <vector>

int main() {
  // A triangle falls through a larger one that does not move.
  const std::vector<selvedge::Vec3> start = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  const std::vector<selvedge::Vec3> end = {{0, 0, -1}, {1, 0, -1}, {0, 1, -1}};
  const std::vector<selvedge::Vec3> ground = {{-1, -1, 0}, {3, -1, 0}, {-1, 3, 0}};
  const std::vector<selvedge::Triangle> triangles = {{0, 1, 2}};

  const std::vector<selvedge::Collision> collisions =
      selvedge::find_collisions({start, end, triangles}, {ground, ground, triangles});
  std::printf("%zu collisions, the first at t = %g\n", collisions.size(), collisions.at(0).toi);
}
