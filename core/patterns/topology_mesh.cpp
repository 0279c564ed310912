// SPDX-License-Identifier: MIT
//
// Cloth from any triangle mesh: edges become springs [VanGelder1998], interior edges hinges.
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

void validate_same_topology(const TriangleMesh& surface, const TriangleMesh& rest) {
  if (surface.vertices.size() != rest.vertices.size())
    throw std::invalid_argument("cloth: the rest mesh has " + std::to_string(rest.vertices.size()) +
                                " vertices, the surface " +
                                std::to_string(surface.vertices.size()));
  const auto [a, b] = std::mismatch(surface.triangles.begin(), surface.triangles.end(),
                                    rest.triangles.begin(), rest.triangles.end());
  if (a != surface.triangles.end() || b != rest.triangles.end())
    throw std::invalid_argument("cloth: triangle " + std::to_string(a - surface.triangles.begin()) +
                                " of the surface is not that of the rest mesh");
}

void validate_rest_shape(const TriangleMesh& rest) {
  if (rest.triangles.empty()) throw std::invalid_argument("cloth: the mesh has no triangles");
  for (std::size_t k = 0; k < rest.triangles.size(); ++k) {
    const auto& [a, b, c] = rest.triangles[k];
    const Vec3 ab = rest.vertices[b] - rest.vertices[a], ac = rest.vertices[c] - rest.vertices[a];
    const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
    // Below this ratio of height to longest side, an angle is rounding error of the coordinates.
    constexpr double thinnest = 1e-9;
    if (!(ab.cross(ac).norm() > thinnest * longest))
      throw std::invalid_argument("cloth: triangle " + std::to_string(k) +
                                  " of the rest mesh has no area; remove it or weld its vertices");
  }
}

void validate_masses(const std::vector<double>& mass) {
  for (std::size_t i = 0; i < mass.size(); ++i)
    if (!(mass[i] > 0.0))
      throw std::invalid_argument("cloth: vertex " + std::to_string(i) +
                                  " belongs to no triangle and would have no mass; remove it");
}

}  // namespace

ClothMesh make_from_mesh(const TriangleMesh& surface, const TriangleMesh& rest,
                         const Material& material) {
  detail::validate_material(material);
  detail::require_hinges(material, "a mesh of triangles");
  validate(surface, "cloth");
  validate(rest, "cloth rest mesh");
  validate_same_topology(surface, rest);
  validate_rest_shape(rest);
  ClothMesh cloth;
  cloth.surface = surface;
  cloth.edges = unique_edges(surface.triangles);
  cloth.mass = vertex_areas(rest.vertices, rest.triangles);
  for (double& m : cloth.mass) m *= material.density;
  validate_masses(cloth.mass);
  detail::add_edge_springs(cloth, rest.vertices, material);
  detail::add_hinges(cloth, rest.vertices, material);
  detail::set_stretch_law(cloth, rest.vertices, material);
  return cloth;
}

void register_mesh(ClothPatternRegistry& registry) {
  registry.add_keyed("mesh", "geometry.*.mesh",
                     {.promise = "any triangle mesh, file order and double precision kept",
                      .source = "Van Gelder, Approximate simulation of elastic membranes, 1998"});
}

}  // namespace selvedge
