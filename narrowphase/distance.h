// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>

#include <vector>

namespace selvedge {

/// Closest points of two primitives: weights as in Contact, and the vector between the points.
struct ClosestPoints {
  std::array<double, 4> weight;  ///< signed, sum 0
  Vec3 separation;               ///< first point minus second point, metres
  double distance;               ///< metres
};

/// Closest point of the closed triangle (a, b, c) to p. Degenerate triangles are legal.
ClosestPoints point_triangle_closest(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Closest points of the closed edges (a0, a1) and (b0, b1). Parallel and zero-length edges are
/// legal; of parallel ones the middle of the overlap is returned.
ClosestPoints edge_edge_closest(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1);

/// Two primitives on the two sides of a slab: normal·(x - y) >= width for every point x of the
/// first and y of the second.
struct SeparatingSlab {
  Vec3 normal;   ///< unit, from the second primitive towards the first
  double width;  ///< metres, rounded down: never more than the distance; 0 if none was found
};

/// The slab across the closest points (or along the common normal where these give no direction).
/// Its width is measured on the vertices, so that it holds however accurate the direction is.
/// `kind` is edge_edge, or anything else for a point and a triangle.
SeparatingSlab separating_slab(ContactKind kind, const std::array<Vec3, 4>& x);

/// How wide a slab across the unit vector `normal` separates them, metres; rounded down, 0 if none.
double slab_width(ContactKind kind, const std::array<Vec3, 4>& x, const Vec3& normal);

/// For every pair, in pair order: weights of the closest points at t = 0, and normal and width of a
/// separating slab there as `normal` and `gap`; toi is 0.
void find_separations(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& pairs,
                      std::vector<Contact>& out);

/// The pairs whose primitives are nearer than `reach` metres at t = 0, plus those whose distance,
/// reduced by the approach along the connecting line over the step, falls below it. In pair order;
/// toi is 0, gap the distance, normal the direction between the closest points (for a distance too
/// small to give one: the triangle normal or the edges' cross product, from the side of t = 0).
void find_proximities(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& pairs,
                      double reach, std::vector<Contact>& out);

}  // namespace selvedge
