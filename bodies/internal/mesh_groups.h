// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace selvedge {

/// A named part of an OBJ file.
struct MeshGroup {
  enum class Kind { object, group, material };  ///< the statements o, g and usemtl
  Kind kind = Kind::group;
  std::string name;
  std::vector<std::int32_t> triangles;  ///< ascending; may be empty
};

/// The triangles of a mesh file, as read_mesh gives them, and their groups. A triangle may belong
/// to several groups. Formats other than OBJ have none.
struct GroupedMesh {
  TriangleMesh mesh;
  std::vector<MeshGroup> groups;  ///< in the order of the file
};
/// Errors as in read_mesh.
GroupedMesh read_grouped_mesh(const std::filesystem::path& file);

/// Keeps the triangles that belong to one of the groups `take`, and the vertices that these need.
/// `name` starts the message of the thrown std::invalid_argument if there is no group of a name, or
/// nothing is left.
TriangleMesh select_groups(const GroupedMesh& grouped, const std::vector<std::string>& take,
                           const std::string& name);

/// A question about the unit of a mesh of this extent (m), if it has hardly the size of a body for
/// cloth: which unit its numbers may be in, and the metres of that unit. Empty without doubt.
std::string ask_about_unit(const Vec3& extent);

}  // namespace selvedge
