// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/detail/box_tree.h>
#include <selvedge/apps/detail/exact_predicates.h>
#include <selvedge/core/triangle_mesh.h>

#include <cstddef>
#include <vector>

namespace selvedge::judging {

/// The closed parts of a mesh, for questions about their inside. A part is a set of triangles
/// joined by edges, where vertices at exactly equal positions count as one; it is closed if every
/// edge has an even number of triangles. Parts with a border are left out.
class ClosedSurface {
 public:
  explicit ClosedSurface(const TriangleMesh& mesh);

  std::size_t closed_parts() const { return closed_parts_; }
  std::size_t open_parts() const { return open_parts_; }

  /// True if x is off the surface and the winding numbers of the consistently oriented parts about
  /// it do not sum to 0 (so the cavity of a shell is outside), or a closed part that is not
  /// consistently oriented is crossed an odd number of times on the way out. Exact.
  bool strictly_contains(const Vec3& x) const;

  /// Distance to the nearest point of the surface, rounded, or `floor` if that is larger:
  /// a search for the largest distance need not finish what cannot beat it. Infinite
  /// if there is no closed part. Never less than `floor`.
  double distance(const Vec3& x, double floor = 0.0) const;

 private:
  struct Face {
    TrianglePoints points;
    std::int32_t part;
    bool oriented;  // every edge of its part is run through as often one way as the other
  };

  std::vector<Face> faces_;
  BoxTree tree_{{}};
  std::size_t closed_parts_ = 0, open_parts_ = 0;
};

}  // namespace selvedge::judging
