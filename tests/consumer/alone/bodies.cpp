// SPDX-License-Identifier: MIT
#include <selvedge/bodies/mesh_report.h>

int main() {
  const selvedge::TriangleMesh tetrahedron{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                           {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  return selvedge::report_mesh(tetrahedron).volume > 0.0 ? 0 : 1;
}
