// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// Reads OBJ, PLY (ASCII, binary little and big endian) or OFF exactly: doubles, file order,
/// polygons split into triangle fans, nothing merged or dropped. Throws std::invalid_argument with
/// one sentence: file, line or byte, fault, remedy. On damaged input it never crashes or hangs, and
/// it never allocates more memory than the file size justifies.
TriangleMesh read_mesh(const std::filesystem::path& file);

/// A per-vertex property of a PLY file, as in the frames that the program writes.
struct NamedValues {
  std::string name;            ///< PLY property name
  std::vector<double> values;  ///< one per vertex
  bool as_byte = false;        ///< stored as uchar: whole numbers from 0 to 255
};

/// Writes binary little-endian PLY in double precision; read_mesh returns the same bits. The file
/// is written under a temporary name and then renamed, so a reader never sees an incomplete file.
/// Throws std::runtime_error naming the file and the cause (full disk, no permission).
void write_ply(const std::filesystem::path& file, std::span<const Vec3> x,
               std::span<const Triangle> triangles, std::span<const NamedValues> extra = {});
/// Reads a PLY file and its extra vertex properties (double and uchar, in file order).
TriangleMesh read_ply(const std::filesystem::path& file, std::vector<NamedValues>& extra);

/// Writes OBJ with 17 significant digits. Errors as in write_ply.
void write_obj(const std::filesystem::path& file, std::span<const Vec3> x,
               std::span<const Triangle> triangles);

}  // namespace selvedge
