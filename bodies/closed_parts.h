// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <cstdint>
#include <vector>

namespace selvedge {

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
