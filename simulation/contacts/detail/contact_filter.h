// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>
#include <selvedge/response/response.h>

#include <array>
#include <span>
#include <vector>

namespace selvedge::detail {

/// A point with a barycentric weight this small is on the border of its primitive.
extern const double kBorder;
/// Slopes above which a neighbour counts as nearer, of points and of edges.
extern const double kPointSlope, kEdgeSlope;

/// Removes false contacts with neighbouring faces. A point that rests on a face also has a closest
/// point on each neighbouring face, at the common edge. As a contact it would be a wall across a
/// flat surface that stops sliding cloth. True contacts are local minima of the distance over the
/// whole surface: with the closest point q on a vertex or an edge, no neighbouring vertex x may lie
/// towards the other primitive, d·(x - q) <= 0. Neighbours are those of common vertices;
/// SurfaceUnion decides the same for faces that only lie against each other.
class ContactFilter {
 public:
  ContactFilter() = default;
  /// `triangles` of all surfaces in the joint index space of ContactPoint, `n` vertices.
  ContactFilter(std::size_t n, std::span<const Triangle> triangles);

  /// Point and triangle (vertex 0 and vertices 1 to 3): whether the closest point of the triangle
  /// is a local minimum over its surface.
  bool is_true_point_contact(const ContactPoint& c, std::span<const Vec3> x) const;
  /// The same for the point at `d`, m, from the one that the weights of the triangle state.
  bool is_nearest(const ContactPoint& c, const Vec3& d, std::span<const Vec3> x) const;
  /// Two edges: the same for the closest points of both, up to a slope.
  bool is_true_edge_contact(const ContactPoint& c, std::span<const Vec3> x) const;

 private:
  bool rises(std::span<const std::int32_t> feature, const Vec3& q, const Vec3& towards,
             double slope, std::span<const Vec3> x) const;

  std::vector<std::size_t> begin_;  // per vertex, into around_
  std::vector<std::array<std::int32_t, 2>>
      around_;  // the other two vertices of a triangle, both ways
};

}  // namespace selvedge::detail
