// SPDX-License-Identifier: MIT
//
// Meshes from files.
#include <selvedge/bindings/c/calls.h>
#include <selvedge/bodies/mesh_file.h>

namespace selvedge::c {

Mesh::Mesh(TriangleMesh mesh) : selvedge_mesh{}, lists(std::move(mesh)) {
  vertices = lists.vertices.size();
  x = reinterpret_cast<const double*>(lists.vertices.data());
  triangle_count = lists.triangles.size();
  triangles = reinterpret_cast<const int32_t*>(lists.triangles.data());
}

}  // namespace selvedge::c

using namespace selvedge;  // NOLINT: the functions below are outside of it

int selvedge_mesh_read(const char* file, selvedge_mesh** out) {
  return c::call([&] {
    c::needed(file, "file");
    c::needed(out, "out");
    *out = new c::Mesh(read_mesh(file));
  });
}
void selvedge_mesh_free(selvedge_mesh* mesh) { delete static_cast<c::Mesh*>(mesh); }
