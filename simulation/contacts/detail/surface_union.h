// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/internal/triangle_tree.h>
#include <selvedge/core/base/types.h>
#include <selvedge/response/response.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// 1 for each vertex of an edge with one triangle; indices are below n.
std::vector<char> border_vertices(std::span<const Triangle> triangles, std::size_t n);

/// Removes contacts with walls that the geometry does not have. Where two faces without a common
/// vertex lie against each other - two boxes side by side, a mesh in patches, a vertex on the edge
/// of a larger face - the border of each is a rim by its own vertices, but no rim of their union.
/// ContactFilter goes by common vertices and keeps it; here all faces within a tolerance of the
/// closest point count as joined there. Faces that meet in one vertex alone lie against each other,
/// too, where a slit ends in it.
///
/// Let q be the closest point of a contact on a border or vertex of its face, p the point on the
/// other side, and T a face that passes q within the tolerance. The union lets a point leave from q
/// along d = p - q only if T does not rise towards p: d·(x - q') <= 0 for its vertices x, with q'
/// the point of T nearest to q. Otherwise a point of T is nearer to p, so that the contact of p
/// with T does the work and this one is a wall: it is removed. Only within the tolerance can q stay
/// the nearest of all, such as over a small step or in the gap itself. Then the contact stays, with
/// the normal of T. So the nearest face of each point always keeps its contact.
class SurfaceUnion {
 public:
  SurfaceUnion() = default;
  /// `triangles` in the joint index space of ContactPoint, of surfaces that count as one.
  explicit SurfaceUnion(std::vector<Triangle> triangles);

  /// Sets the positions of the joint index space, m.
  void fit(std::span<const Vec3> x) { tree_.fit(x); }

  /// The faces that a contact takes into account: those of surfaces that collide with its piece.
  struct Reach {
    double tolerance = 0.0;                 ///< m
    std::span<const std::int32_t> surface;  ///< of each joint vertex
    std::span<const char> collides;         ///< by surface; empty: all do
    /// Of each joint vertex: on an edge with one triangle. Then only borders join, so that layers
    /// which are pressed together stay layers. Empty: all faces join.
    std::span<const char> border;
  };

  /// Whether the second primitive of the contact is no wall: a triangle met by a point, or an edge
  /// met by an edge. May turn the normal of a contact that stays, which changes its gap, too.
  bool is_true_contact(ContactPoint& c, std::span<const Vec3> x, const Reach& reach) const;

 private:
  struct Meeting;
  struct Verdict;
  Verdict judge(const Meeting& meeting, std::span<const Vec3> x, const Reach& reach) const;
  static void turn(ContactPoint& c, const Vec3& normal, std::span<const Vec3> x);

  TriangleTree tree_;
  std::vector<char> is_open_;  // of each vertex: on an edge with one triangle
};

}  // namespace selvedge::detail
