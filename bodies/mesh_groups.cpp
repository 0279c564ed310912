// SPDX-License-Identifier: MIT
#include <selvedge/bodies/detail/mesh_source.h>
#include <selvedge/bodies/internal/mesh_groups.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <stdexcept>

namespace selvedge {
namespace {

std::string list_of_groups(const std::vector<MeshGroup>& groups) {
  constexpr std::size_t most = 20;
  std::string list;
  for (std::size_t i = 0; i < std::min(groups.size(), most); ++i)
    list += (i == 0 ? "" : ", ") + detail::in_quotes(groups[i].name);
  return groups.size() > most ? list + " and " + std::to_string(groups.size() - most) + " more"
                              : list;
}

/// Marks the triangles of all groups with one of the names.
std::vector<char> marked(const GroupedMesh& grouped, const std::vector<std::string>& names,
                         const std::string& file) {
  std::vector<char> mark(grouped.mesh.triangles.size(), 0);
  for (const std::string& name : names) {
    bool found = false;
    for (const MeshGroup& group : grouped.groups) {
      if (group.name != name) continue;
      found = true;
      for (const std::int32_t t : group.triangles) mark[t] = 1;
    }
    if (found) continue;
    throw std::invalid_argument(
        file + ": has no group, object or material " + detail::in_quotes(name) +
        (grouped.groups.empty() ? "; only OBJ files with statements g, o or usemtl have them"
                                : "; it has " + list_of_groups(grouped.groups)));
  }
  return mark;
}

}  // namespace

GroupedMesh read_grouped_mesh(const std::filesystem::path& file) {
  GroupedMesh grouped;
  if (detail::lower_extension(file) != ".obj") {
    grouped.mesh = read_mesh(file);
    return grouped;
  }
  const detail::MeshSource source = detail::read_source(file);
  grouped.mesh = detail::read_obj(source, &grouped.groups);
  detail::require_surface(source, grouped.mesh);
  return grouped;
}

TriangleMesh select_groups(const GroupedMesh& grouped, const std::vector<std::string>& take,
                           const std::string& name) {
  const std::vector<char> in = marked(grouped, take, name);
  TriangleMesh mesh;
  mesh.vertices = grouped.mesh.vertices;
  for (std::size_t t = 0; t < grouped.mesh.triangles.size(); ++t)
    if (in[t]) mesh.triangles.push_back(grouped.mesh.triangles[t]);
  if (mesh.triangles.empty())
    throw std::invalid_argument(name + ": no triangle is left of the chosen groups; it has " +
                                list_of_groups(grouped.groups));
  detail::drop_unused_vertices(mesh);
  return mesh;
}

std::string ask_about_unit(const Vec3& extent) {
  struct Guess {
    double above;  // m, of the largest extent
    const char* unit;
    const char* metres;
  };
  // A person is 1.7 m, 5.6 feet, 17 dm, 67 inches, 170 cm or 1700 mm tall.
  constexpr std::array<Guess, 5> guesses = {{{400.0, "millimetres", "0.001"},
                                             {90.0, "centimetres", "0.01"},
                                             {30.0, "inches or centimetres", "0.0254 or 0.01"},
                                             {10.0, "decimetres", "0.1"},
                                             {4.0, "feet", "0.3048"}}};
  const double largest = extent.maxCoeff();
  for (const Guess& guess : guesses) {
    if (!(largest > guess.above)) continue;
    char size[32];
    std::snprintf(size, sizeof size, "%.4g", largest);
    return std::string("it is ") + size + " m large; are its numbers " + guess.unit +
           "? Then the unit is " + guess.metres + " m";
  }
  return "";
}

}  // namespace selvedge
