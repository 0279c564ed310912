// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <string>
#include <vector>

namespace selvedge {

/// What is wrong with a mesh as a body. Counts; 0 everywhere means closed, oriented and clean.
struct MeshReport {
  std::size_t vertices = 0, triangles = 0, components = 0;
  std::size_t boundary_edges = 0;      ///< edges with one triangle: the surface is open
  std::size_t non_manifold_edges = 0;  ///< edges with more than two triangles
  std::size_t inconsistent_edges = 0;  ///< both triangles run along the edge in the same direction
  std::size_t duplicate_faces = 0;
  std::size_t zero_area_faces = 0;
  std::size_t duplicate_vertices = 0;
  std::size_t unused_vertices = 0;
  std::size_t inward_components = 0;   ///< closed parts with negative volume
  std::size_t self_intersections = 0;  ///< pairs of triangles without a common vertex that cross
  std::size_t folded_neighbours =
      0;                ///< pairs with a common vertex that meet beyond what they share
  double volume = 0.0;  ///< m³, signed, of a closed mesh
  Vec3 lower = Vec3::Zero(), upper = Vec3::Zero();

  bool closed() const { return boundary_edges == 0 && non_manifold_edges == 0; }
  /// One sentence for each fault, empty if there is none.
  std::vector<std::string> sentences() const;
};

MeshReport report_mesh(const TriangleMesh& mesh);

}  // namespace selvedge
