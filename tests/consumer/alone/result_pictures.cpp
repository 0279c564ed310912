// SPDX-License-Identifier: MIT
#include <selvedge/pictures/result_pictures.h>

#include <vector>

int main() {
  const std::vector<selvedge::Triangle> triangles = {{0, 1, 2}, {3, 4, 5}};
  return selvedge::connected_parts(6, triangles).size() == 2 ? 0 : 1;
}
