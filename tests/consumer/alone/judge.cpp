// SPDX-License-Identifier: MIT
#include <selvedge/judge/judge.h>

int main() {
  const selvedge::TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  const selvedge::TriangleMesh body{{{0.2, 0.2, -1}, {0.2, 0.2, 1}, {1, 1, 1}}, {{0, 1, 2}}};
  return selvedge::judge(mesh, body, {}).body_intersections == 1 ? 0 : 1;
}
