// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>
#include <selvedge/judge/detail/box_tree.h>
#include <selvedge/judge/detail/exact_predicates.h>

#include <cstddef>
#include <vector>

namespace selvedge::judging {

/// The closed parts of a mesh, for queries about their inside. A part is a set of triangles joined
/// by edges; vertices at exactly equal positions count as one. A part is closed if every edge has
/// an even number of triangles. Parts with a border are ignored.
class ClosedSurface {
 public:
  explicit ClosedSurface(const TriangleMesh& mesh);

  std::size_t closed_parts() const { return closed_parts_; }
  std::size_t open_parts() const { return open_parts_; }

  /// True if x is not on the surface and one of two conditions holds: the winding numbers of the
  /// consistently oriented parts about x do not sum to 0 (so the cavity of a shell is outside), or
  /// a ray from x crosses a closed part that is not consistently oriented an odd number of times.
  /// Exact.
  bool strictly_contains(const Vec3& x) const;

  /// Distance to the nearest point of the surface (rounded), or `floor` if that is larger. A search
  /// for the largest distance passes the largest one so far as `floor`, so that smaller distances
  /// need not be computed. Infinite if there is no closed part.
  double distance(const Vec3& x, double floor = 0.0) const;

 private:
  struct Face {
    TrianglePoints points;
    std::int32_t part;
    bool oriented;  // each edge of its part is traversed equally often both ways
  };

  std::vector<Face> faces_;
  BoxTree tree_{{}};
  std::size_t closed_parts_ = 0, open_parts_ = 0;
};

}  // namespace selvedge::judging
