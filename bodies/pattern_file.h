// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <filesystem>

namespace selvedge {

/// The flat pattern of a garment: the texture coordinates of an OBJ file as positions in the
/// xy-plane, m, each `unit` metres, as ARCSim's files have them. Triangle i is that of
/// read_mesh(file); along a seam a corner of the surface has several places in the pattern. Throws
/// std::invalid_argument with file, line, fault and remedy: no OBJ, a corner without a texture
/// coordinate, an index that is not there.
TriangleMesh read_pattern(const std::filesystem::path& file, double unit = 1.0);

}  // namespace selvedge
