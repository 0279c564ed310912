// SPDX-License-Identifier: MIT
#include <selvedge/core/base/types.h>

#include <vector>

int main() {
  const std::vector<selvedge::Triangle> triangles = {{0, 1, 2}, {2, 1, 3}};
  return selvedge::unique_edges(triangles).size() == 5 ? 0 : 1;
}
