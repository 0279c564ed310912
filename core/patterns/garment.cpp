// SPDX-License-Identifier: MIT
//
// Garments from their flat pattern, as in ARCSim's files: the texture coordinates are the material
// space. The pieces become cloth in the plane. Sewing merges all pattern positions of a surface
// corner into one particle.
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <algorithm>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

std::vector<std::int32_t> corner_of_place(const TriangleMesh& surface,
                                          const TriangleMesh& pattern) {
  std::vector<std::int32_t> corner(pattern.vertices.size(), -1);
  for (std::size_t i = 0; i < pattern.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      std::int32_t& known = corner[pattern.triangles[i][k]];
      const std::int32_t vertex = surface.triangles[i][k];
      if (known >= 0 && known != vertex)
        throw std::invalid_argument(
            "pattern: triangle " + std::to_string(i) + ": vertices " + std::to_string(known) +
            " and " + std::to_string(vertex) +
            " of the surface share a place in the pattern; give each its own");
      known = vertex;
    }
  return corner;
}

/// Drops positions that no triangle uses; they would have no mass.
TriangleMesh used_part(const TriangleMesh& pattern) {
  std::vector<std::int32_t> number(pattern.vertices.size(), -1);
  TriangleMesh used;
  for (Triangle t : pattern.triangles) {
    for (std::int32_t& v : t) {
      if (number[v] < 0) {
        number[v] = static_cast<std::int32_t>(used.vertices.size());
        used.vertices.push_back(pattern.vertices[v]);
      }
      v = number[v];
    }
    used.triangles.push_back(t);
  }
  return used;
}

void require_no_fold(const TriangleMesh& pattern) {
  for (std::size_t i = 0; i < pattern.triangles.size(); ++i) {
    const auto& [a, b, c] = pattern.triangles[i];
    const Vec3 u = pattern.vertices[b] - pattern.vertices[a],
               v = pattern.vertices[c] - pattern.vertices[a];
    if (u.x() * v.y() == u.y() * v.x())
      throw std::invalid_argument("pattern: triangle " + std::to_string(i) +
                                  " has no area in the pattern; spread it out");
  }
}

void validate_pair(const TriangleMesh& surface, const TriangleMesh& pattern) {
  validate(surface, "garment");
  validate(pattern, "pattern");
  if (surface.triangles.size() != pattern.triangles.size())
    throw std::invalid_argument("pattern: " + std::to_string(pattern.triangles.size()) +
                                " triangles for the surface's " +
                                std::to_string(surface.triangles.size()));
  require_no_fold(pattern);
}

/// A cloth of this surface without elements.
ClothMesh bare_cloth(const TriangleMesh& surface) {
  ClothMesh cloth;
  cloth.surface = surface;
  cloth.edges = unique_edges(surface.triangles);
  cloth.mass.assign(surface.vertices.size(), 0.0);
  return cloth;
}

/// Adds the elements and masses of flat pieces; `surface` has their triangles.
void add_pieces(const TriangleMesh& surface, const TriangleMesh& pattern, const Material& material,
                ClothMesh& cloth) {
  const TriangleMesh flat = used_part(pattern);
  const std::vector<std::int32_t> corner = corner_of_place(surface, flat);
  const ClothMesh pieces = make_from_mesh(flat, flat, material);
  for (std::size_t i = 0; i < corner.size(); ++i) cloth.mass[corner[i]] += pieces.mass[i];
  add_elements(cloth, pieces, corner);
}

void validate_masses(const ClothMesh& cloth) {
  for (std::size_t i = 0; i < cloth.mass.size(); ++i)
    if (!(cloth.mass[i] > 0.0))
      throw std::invalid_argument("garment: vertex " + std::to_string(i) +
                                  " belongs to no triangle and would have no mass; remove it");
}

}  // namespace

ClothMesh make_from_pattern(const TriangleMesh& surface, const TriangleMesh& pattern,
                            const Material& material) {
  validate_pair(surface, pattern);
  ClothMesh cloth = bare_cloth(surface);
  add_pieces(surface, pattern, material, cloth);
  validate_masses(cloth);
  return cloth;
}

ClothMesh make_from_pattern(const TriangleMesh& surface, const TriangleMesh& pattern,
                            std::span<const Material> materials,
                            std::span<const std::int32_t> fabric) {
  validate_pair(surface, pattern);
  if (fabric.size() != pattern.triangles.size())
    throw std::invalid_argument("pattern: " + std::to_string(fabric.size()) + " fabrics for " +
                                std::to_string(pattern.triangles.size()) + " triangles");
  ClothMesh cloth = bare_cloth(surface);
  for (std::size_t m = 0; m < materials.size(); ++m) {
    TriangleMesh worn{surface.vertices, {}}, flat{pattern.vertices, {}};
    for (std::size_t i = 0; i < fabric.size(); ++i) {
      if (fabric[i] < 0 || static_cast<std::size_t>(fabric[i]) >= materials.size())
        throw std::invalid_argument("pattern: triangle " + std::to_string(i) + " has fabric " +
                                    std::to_string(fabric[i]) + " of " +
                                    std::to_string(materials.size()));
      if (static_cast<std::size_t>(fabric[i]) != m) continue;
      worn.triangles.push_back(surface.triangles[i]);
      flat.triangles.push_back(pattern.triangles[i]);
    }
    if (!flat.triangles.empty()) add_pieces(worn, flat, materials[m], cloth);
  }
  validate_masses(cloth);
  return cloth;
}

}  // namespace selvedge
