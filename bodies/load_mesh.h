// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <filesystem>
#include <string>

namespace selvedge {

enum class UpAxis { x, y, z };

struct LoadConfig {
  double unit = 1.0;      ///< metres per file unit, > 0
  UpAxis up = UpAxis::z;  ///< which axis of the file points up; turned to +z
  bool weld = true;       ///< merge vertices at exactly equal positions, drop unused ones
  double timeout = 30.0;  ///< s, for formats that need assimp
  std::size_t memory_limit = std::size_t{4} << 30;  ///< bytes, for the same
};

/// Reads a body mesh: OBJ, PLY and OFF with our own exact reader, every other format (STL, glTF, …)
/// through assimp in a child process, so that a hang, an abort or a crash of it becomes an error
/// sentence. Throws std::invalid_argument (bad file) naming file, fault and remedy.
TriangleMesh load_mesh(const std::filesystem::path& file, const LoadConfig& config = {});

/// The same for a mesh that was read or made elsewhere: turned, scaled, checked, welded. `name`
/// stands in the sentence of a refusal.
TriangleMesh prepare_mesh(TriangleMesh mesh, const LoadConfig& config, const std::string& name);

}  // namespace selvedge
