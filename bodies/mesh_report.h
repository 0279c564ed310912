// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <cstdint>
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
  std::size_t self_intersections = 0;  ///< pairs without a common vertex that cross or touch
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

/// The closed parts of a mesh and what lies inside them. Triangles that share an edge belong to one
/// part; vertices at the same position count as one. A part is closed if every edge has an even
/// number of triangles. Open parts have no inside.
class ClosedParts {
 public:
  explicit ClosedParts(const TriangleMesh& mesh);

  bool empty() const { return faces_.empty(); }
  /// Whether x is within the bounds of the closed parts: a quick test that most points fail.
  bool may_contain(const Vec3& x) const {
    return (lower_.array() <= x.array()).all() && (x.array() <= upper_.array()).all();
  }
  /// A triangle of the mesh whose part lies around x, or -1 if x is outside. Exact for every x that
  /// is not on the surface.
  ///
  /// The winding numbers of all parts that are consistently oriented are added, so that the cavity
  /// of a shell with two surfaces is outside, and which way a single surface faces does not matter.
  /// A part that is not consistently oriented counts if a ray from x crosses it an odd number of
  /// times.
  std::int32_t part_around(const Vec3& x) const;

 private:
  struct Face {
    std::int32_t triangle;
    std::int32_t part;
    Vec3 a, b, c;
  };

  std::vector<Face> faces_;     // of the closed parts
  std::vector<char> oriented_;  // by part
  Vec3 lower_, upper_;          // bounds; lower_ > upper_ without faces
};

}  // namespace selvedge
