// SPDX-License-Identifier: MIT
// Sewing patterns: a pattern that is read can be meshed or is refused with a sentence, and every
// vertex of the mesh is finite and every triangle valid.
#include <selvedge/garment/panel_mesh.h>

#include <cstdlib>

#include "fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t n) {
  using namespace selvedge;
  try {
    const SewingPattern pattern =
        parse_sewing_pattern(std::string(reinterpret_cast<const char*>(bytes), n), "fuzz");
    PanelMeshConfig config;
    config.edge_length = 0.05;
    config.vertices = 20000;
    const GarmentMesh mesh = mesh_garment(pattern, config);
    for (const Vec3& x : mesh.placed)
      if (!x.allFinite()) std::abort();
    validate(mesh.flat, "flat");
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
