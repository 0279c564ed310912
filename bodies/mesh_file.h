// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <filesystem>
#include <optional>
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

/// Axis of the file that points up.
enum class UpAxis { x, y, z };

/// How a body mesh is read.
struct LoadConfig {
  /// Metres per unit of the file, > 0. Empty: what the file states; 1 if it states nothing.
  std::optional<double> unit{};
  /// Axis of the file that points up; it is rotated to +z. Empty: what the file states; z if it
  /// states nothing.
  std::optional<UpAxis> up{};
  bool weld = true;  ///< merge vertices at identical positions and drop unused ones
  /// Names of groups, objects or materials of an OBJ file: only these are read; empty: all.
  std::vector<std::string> groups{};
  double timeout = 30.0;  ///< s, time limit for formats that need assimp
  std::size_t memory_limit = std::size_t{4}
                             << 30;  ///< bytes, memory limit for formats that need assimp
};

/// Reads a body mesh. OBJ, PLY and OFF use the exact built-in readers; other formats (STL, glTF, …)
/// are read by assimp in a child process, so a hang, abort or crash of assimp becomes an error
/// message. Throws std::invalid_argument naming the file, the fault and a remedy.
TriangleMesh load_mesh(const std::filesystem::path& file, const LoadConfig& config = {});

/// The unit and the up axis of a mesh file.
struct FileAxes {
  double unit = 1.0;      ///< metres per unit of the file
  UpAxis up = UpAxis::z;  ///< axis of the file that points up
  /// Whether the file states them itself: glTF is always in metres with y up, Collada and FBX name
  /// both.
  bool unit_stated = false, up_stated = false;
};

/// A body mesh and the axes with which it was read: those of the LoadConfig, else those that the
/// file states.
struct BodyMesh {
  TriangleMesh mesh;
  FileAxes axes;
};

/// load_mesh that also returns the axes.
BodyMesh load_body_mesh(const std::filesystem::path& file, const LoadConfig& config = {});

/// Whether files of this name state their unit and up axis: glTF, Collada and FBX.
bool states_axes(const std::filesystem::path& file);

/// Rotates, scales, checks and welds a mesh that was read or made elsewhere. `name` starts the
/// message of a thrown std::invalid_argument.
TriangleMesh prepare_mesh(TriangleMesh mesh, const LoadConfig& config, const std::string& name);

/// What weld_vertices has done to a mesh.
struct WeldReport {
  std::size_t vertices = 0;   ///< before
  std::size_t joined = 0;     ///< of these, how many became one with another
  std::size_t collapsed = 0;  ///< triangles that lost a corner and are gone
  double farthest = 0.0;      ///< m, largest distance of two vertices that became one
};

/// Joins vertices that are at most `distance` apart, m: each with the nearest one before it that
/// was not joined itself, whose position it takes. Removes triangles that lose a corner, and
/// vertices of no triangle. The result depends on the order of the vertices alone. Throws
/// std::invalid_argument unless the distance is finite and > 0.
WeldReport weld_vertices(TriangleMesh& mesh, double distance);

/// Reads the flat pattern of a garment from the texture coordinates of an OBJ file, as in ARCSim's
/// files: positions in the xy-plane, m, where one texture unit is `unit` metres. Triangle i
/// corresponds to triangle i of read_mesh(file). A corner on a seam has several positions in the
/// pattern. Throws std::invalid_argument naming file, line, fault and remedy if the file is not
/// OBJ, a corner has no texture coordinate, or an index is out of range.
TriangleMesh read_pattern(const std::filesystem::path& file, double unit = 1.0);

}  // namespace selvedge
