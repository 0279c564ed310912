// SPDX-License-Identifier: MIT
#include <selvedge/bodies/mesh_file.h>

int main() {
  const selvedge::TriangleMesh triangle{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  selvedge::write_ply("alone_mesh_files.ply", triangle.vertices, triangle.triangles);
  return selvedge::load_mesh("alone_mesh_files.ply").vertices == triangle.vertices ? 0 : 1;
}
