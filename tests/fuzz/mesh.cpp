// SPDX-License-Identifier: MIT
// Readers of OBJ, PLY and OFF, and of patterns. The first byte chooses one. A mesh that is read has
// only valid indices, and a PLY that is written from it is read as the same bits.
#include <selvedge/bodies/mesh_file.h>

#include <cstdlib>

#include "fuzz.h"

namespace {

using namespace selvedge;

void check(const TriangleMesh& mesh) {
  for (const Triangle& t : mesh.triangles)
    for (const std::int32_t v : t)
      if (v < 0 || static_cast<std::size_t>(v) >= mesh.vertices.size()) std::abort();
  for (const Vec3& x : mesh.vertices)
    if (!x.allFinite()) std::abort();
}

void check_round_trip(const TriangleMesh& mesh) {
  static const fuzz::InputFile copy("_copy.ply");
  const auto& file = copy.holding(nullptr, 0);
  write_ply(file, mesh.vertices, mesh.triangles);
  const TriangleMesh again = read_mesh(file);
  if (again.vertices != mesh.vertices || again.triangles != mesh.triangles) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t n) {
  static const fuzz::InputFile obj(".obj"), ply(".ply"), off(".off");
  if (n == 0) return 0;
  const int choice = bytes[0] % 5;
  const fuzz::InputFile& input = choice == 1 || choice == 2 ? ply : (choice == 3 ? off : obj);
  const auto& file = input.holding(bytes + 1, n - 1);
  try {
    if (choice == 4) {
      check(read_pattern(file, 0.5));
    } else if (choice == 2) {
      std::vector<NamedValues> extra;
      const TriangleMesh mesh = read_ply(file, extra);
      check(mesh);
      for (const NamedValues& values : extra)
        if (values.values.size() != mesh.vertices.size()) std::abort();
    } else {
      const TriangleMesh mesh = read_mesh(file);
      check(mesh);
      check_round_trip(mesh);
    }
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
