// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <string>
#include <vector>

namespace selvedge {

/// Defects of a mesh that is used as a body. All counts are 0 for a closed, oriented and clean
/// mesh.
struct MeshReport {
  std::size_t vertices = 0, triangles = 0, components = 0;
  std::size_t boundary_edges = 0;      ///< edges with only one triangle: the surface is open
  std::size_t non_manifold_edges = 0;  ///< edges with more than two triangles
  std::size_t inconsistent_edges = 0;  ///< edges that both triangles traverse in the same direction
  std::size_t duplicate_faces = 0;
  std::size_t zero_area_faces = 0;
  std::size_t duplicate_vertices = 0;
  std::size_t unused_vertices = 0;
  std::size_t inward_components = 0;   ///< closed components with negative volume
  std::size_t self_intersections = 0;  ///< crossing pairs of triangles without a common vertex
  /// Pairs of triangles with a common vertex that meet beyond their shared vertex or edge.
  std::size_t folded_neighbours = 0;
  double volume = 0.0;  ///< m³, signed; of a closed mesh
  Vec3 lower = Vec3::Zero(), upper = Vec3::Zero();

  bool closed() const { return boundary_edges == 0 && non_manifold_edges == 0; }
  /// One sentence for each kind of defect; empty if there is none.
  std::vector<std::string> sentences() const;
};

/// Counts the defects of `mesh`. Throws std::invalid_argument for a coordinate that is not finite
/// or an index out of range.
MeshReport report_mesh(const TriangleMesh& mesh);

}  // namespace selvedge
