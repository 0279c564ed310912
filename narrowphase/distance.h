// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>

#include <array>
#include <limits>
#include <vector>

namespace selvedge {

/// Closest points of two primitives: weights as in Contact, and the vector between the points.
struct ClosestPoints {
  std::array<double, 4> weight;  ///< signed, sum 0
  Vec3 separation;               ///< first point minus second point, metres
  double distance;               ///< metres
};

/// Closest point of the closed triangle (a, b, c) to p, metres. Degenerate triangles are allowed.
ClosestPoints point_triangle_closest(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Closest points of the closed edges (a0, a1) and (b0, b1), metres. Parallel and zero-length edges
/// are allowed; for parallel edges the middle of the overlap is returned.
ClosestPoints edge_edge_closest(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1);

/// A slab with the two primitives on its two sides: normal·(x - y) >= width for every point x of
/// the first primitive and y of the second.
struct SeparatingSlab {
  Vec3 normal;   ///< unit, from the second primitive towards the first
  double width;  ///< metres, rounded down: never more than the distance; 0 if no slab was found
};

/// The slab perpendicular to the vector between the closest points (or along the common normal if
/// these give no direction). Its width is measured on the vertices, so it holds however accurate
/// the direction is. `kind` is edge_edge, or any other value for a point and a triangle.
SeparatingSlab separating_slab(ContactKind kind, const std::array<Vec3, 4>& x);

/// Width of the slab perpendicular to the unit vector `normal` that separates the primitives,
/// metres; rounded down, 0 if there is none.
double slab_width(ContactKind kind, const std::array<Vec3, 4>& x, const Vec3& normal);

/// Writes to `out`, for every pair in pair order, the weights of the closest points at t = 0, and
/// the normal and width of a separating slab there as `normal` and `gap`; toi is 0.
void find_separations(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& pairs,
                      std::vector<Contact>& out);

/// Distances of find_proximities, in metres.
struct ProximityReach {
  double reach = 0.0;  ///< a pair nearer than this at t = 0, or after its approach, counts
  /// Only pairs that are nearer than this at t = 0 count: those of a point of `a` and a triangle of
  /// `b`, and all others.
  double primary_at_start = std::numeric_limits<double>::infinity();
  double secondary_at_start = std::numeric_limits<double>::infinity();
};

/// Writes to `out` the pairs whose primitives are nearer than `reach` at t = 0, and those whose
/// distance falls below it after subtracting the approach along the connecting line over the step.
/// In pair order; toi is 0, gap the distance at t = 0, normal the direction between the closest
/// points there (if the distance is too small to give one: the triangle normal or the cross product
/// of the edges, towards the side at t = 0).
void find_proximities(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& pairs,
                      const ProximityReach& reach, std::vector<Contact>& out);

/// The same, and writes the clearance of every pair to `rooms`, m: the pair shares no point during
/// the step while x_t0 stays and the ends change by less than this: the largest change of a
/// coordinate of x_t1 in the one primitive, plus that in the other. Negative: unknown.
void find_proximities(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& pairs,
                      const ProximityReach& reach, std::vector<Contact>& out,
                      std::vector<float>& rooms);

}  // namespace selvedge
