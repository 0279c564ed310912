// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/internal/triangle_tree.h>
#include <selvedge/core/base/types.h>
#include <selvedge/dress/detail/winding_number.h>

#include <cstdint>
#include <limits>

namespace selvedge::detail {

/// The surface of a body: closest points, and which side of it a point is on.
class BodySurface {
 public:
  /// This is a view: its creator keeps the body alive.
  explicit BodySurface(const TriangleMesh& body);

  struct Nearest {
    Vec3 point = Vec3::Zero();  ///< m, of the surface
    std::int32_t triangle = -1;
    double distance = std::numeric_limits<double>::infinity();  ///< m
  };
  /// The closest point. It looks in growing boxes, the first of which reaches `reach` (m) far.
  Nearest nearest(const Vec3& p, double reach) const;
  /// The closest point within `reach` (m); without one, `triangle` is -1.
  Nearest nearest_within(const Vec3& p, double reach) const;
  Vec3 normal(std::int32_t triangle) const;  ///< unit, outward
  bool is_inside(const Vec3& p) const;

 private:
  const Vec3& corner(std::int32_t triangle, int k) const;

  const TriangleMesh& body_;
  WindingNumber winding_;
  TriangleTree tree_;
};

}  // namespace selvedge::detail
