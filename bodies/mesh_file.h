// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// Reads OBJ, PLY (ASCII, binary little and big endian) or OFF exactly: doubles, file order,
/// polygons fanned into triangles, nothing merged or dropped. Throws std::invalid_argument with one
/// sentence: file, line or byte, fault, remedy. Never crashes or hangs on damaged input; never
/// allocates more than the file's size warrants.
TriangleMesh read_mesh(const std::filesystem::path& file);

/// Extra vertex data of a PLY file that our own frames carry.
struct NamedValues {
  std::string name;            ///< PLY property name
  std::vector<double> values;  ///< one per vertex
  bool as_byte = false;        ///< stored as uchar: whole numbers from 0 to 255
};

/// Binary little-endian PLY, double precision: read_mesh gives back the same bits. Written to a
/// temporary file beside it and renamed, so that a reader never sees half a file. Throws
/// std::runtime_error with file and cause (full disk, no permission).
void write_ply(const std::filesystem::path& file, std::span<const Vec3> x,
               std::span<const Triangle> triangles, std::span<const NamedValues> extra = {});
/// Same, and reads the extra vertex properties back (double and uchar ones, in file order).
TriangleMesh read_ply(const std::filesystem::path& file, std::vector<NamedValues>& extra);

/// OBJ with 17 significant digits.
void write_obj(const std::filesystem::path& file, std::span<const Vec3> x,
               std::span<const Triangle> triangles);

}  // namespace selvedge
