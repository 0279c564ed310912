// SPDX-License-Identifier: MIT
//
// Meshes from files.
#include <selvedge/bindings/c/calls.h>
#include <selvedge/bodies/mesh_file.h>

#include <memory>

namespace selvedge::c {
namespace {

/// The lists behind a selvedge_mesh, which is its first part.
struct Mesh : selvedge_mesh {
  TriangleMesh lists;
};

}  // namespace
}  // namespace selvedge::c

using namespace selvedge;  // NOLINT: the functions below are outside of it

int selvedge_mesh_read(const char* file, selvedge_mesh** out) {
  return c::call([&] {
    c::needed(file, "file");
    c::needed(out, "out");
    auto mesh = std::make_unique<c::Mesh>(c::Mesh{{}, read_mesh(file)});
    mesh->vertices = mesh->lists.vertices.size();
    mesh->x = reinterpret_cast<const double*>(mesh->lists.vertices.data());
    mesh->triangle_count = mesh->lists.triangles.size();
    mesh->triangles = reinterpret_cast<const int32_t*>(mesh->lists.triangles.data());
    *out = mesh.release();
  });
}
void selvedge_mesh_free(selvedge_mesh* mesh) { delete static_cast<c::Mesh*>(mesh); }
