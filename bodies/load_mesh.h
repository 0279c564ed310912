// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <filesystem>
#include <string>

namespace selvedge {

/// Axis of the file that points up.
enum class UpAxis { x, y, z };

/// How a body mesh is read.
struct LoadConfig {
  double unit = 1.0;      ///< metres per file unit, > 0
  UpAxis up = UpAxis::z;  ///< axis of the file that points up; it is rotated to +z
  bool weld = true;       ///< merge vertices at identical positions and drop unused ones
  double timeout = 30.0;  ///< s, time limit for formats that need assimp
  std::size_t memory_limit = std::size_t{4}
                             << 30;  ///< bytes, memory limit for formats that need assimp
};

/// Reads a body mesh. OBJ, PLY and OFF use the exact built-in readers; other formats (STL, glTF, …)
/// are read by assimp in a child process, so a hang, abort or crash of assimp becomes an error
/// message. Throws std::invalid_argument naming the file, the fault and a remedy.
TriangleMesh load_mesh(const std::filesystem::path& file, const LoadConfig& config = {});

/// Rotates, scales, checks and welds a mesh that was read or made elsewhere. `name` starts the
/// message of a thrown std::invalid_argument.
TriangleMesh prepare_mesh(TriangleMesh mesh, const LoadConfig& config, const std::string& name);

}  // namespace selvedge
