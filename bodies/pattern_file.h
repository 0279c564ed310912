// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <filesystem>

namespace selvedge {

/// Reads the flat pattern of a garment from the texture coordinates of an OBJ file, as in ARCSim's
/// files: positions in the xy-plane, m, where one texture unit is `unit` metres. Triangle i
/// corresponds to triangle i of read_mesh(file). A corner on a seam has several positions in the
/// pattern. Throws std::invalid_argument naming file, line, fault and remedy if the file is not
/// OBJ, a corner has no texture coordinate, or an index is out of range.
TriangleMesh read_pattern(const std::filesystem::path& file, double unit = 1.0);

}  // namespace selvedge
