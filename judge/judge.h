// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace selvedge {

/// Result of `judge`, which `selvedge check` prints. All counts are exact for every finite
/// coordinate: a proven floating-point filter decides the easy cases, integers of arbitrary length
/// the rest. The judge shares no code with bodies, broadphase, narrowphase, detection or response.
///
/// Two triangles *cross* if their insides have a common point: an edge of one passes through the
/// inside of the other, or both lie in one plane and overlap in area. A triangle also crosses the
/// triangles at an edge that lies in its plane and passes along its inside, if they are on both
/// sides of it: the surface passes through it exactly along the edge. They *touch* if they do not
/// cross, but primitives of them without a common vertex have a common point: a corner or an edge
/// of one and the other triangle, or two edges. Vertices are common by index; equal positions of
/// different indices touch. A degenerate triangle is the segment or point that its corners span. It
/// has no area, so it crosses only a triangle whose inside the segment passes through.
struct Verdict {
  std::size_t vertices = 0, triangles = 0;
  /// Pairs of mesh triangles that cross, with and without common vertices.
  std::size_t self_intersections = 0;
  std::size_t body_intersections = 0;  ///< a mesh triangle and a body triangle that cross
  std::size_t self_touches = 0, body_touches = 0;  ///< the same for pairs that touch
  /// Mesh vertices strictly inside the closed parts of the body. A vertex is inside if the winding
  /// numbers of the consistently oriented parts about it do not sum to 0, or if it lies inside a
  /// closed part that is not consistently oriented.
  std::size_t inside_vertices = 0;
  /// Largest distance of these vertices to the surface of the closed parts. This distance and the
  /// strains are rounded; all other numbers are exact.
  double max_penetration_m = 0.0;
  double max_stretch = 0.0, max_compression = 0.0;  ///< strain of edges relative to the rest mesh
  /// Up to 10 pairs each: those that cross, and those that touch.
  std::vector<std::pair<std::int32_t, std::int32_t>> first_self, first_body, first_self_touches,
      first_body_touches;
  /// Connected parts of the body. Triangles connect through edges; vertices at equal positions
  /// count as one. Open parts (with a border) have no inside.
  std::size_t closed_parts = 0, open_parts = 0;
};

/// `body` and `rest` may be empty. Throws std::invalid_argument if a coordinate is not finite, if
/// an index is out of range, or if the rest mesh has an edge of length 0 or differs from the mesh
/// in its triangles or its number of vertices.
Verdict judge(const TriangleMesh& mesh, const TriangleMesh& body, const TriangleMesh& rest);

/// Result of `judge_path`: pairs of primitives that collide while every vertex moves on a straight
/// line from one state to the other. Integers decide exactly. Primitives are the triangles, their
/// edges and the vertices that they use. Pairs of the mesh that share a vertex (by index) are not
/// tested. If neither state has an intersection and the path has no collision, the whole motion is
/// free of intersections.
struct PathVerdict {
  std::size_t pairs = 0;  ///< primitive pairs with overlapping swept boxes
  std::size_t self_collisions = 0, body_collisions = 0;
};

/// The body may be empty. If `one` is not empty, it has a number for each vertex of the mesh, and
/// vertices with the same number count as one vertex: they become one at the end of the path.
/// Throws std::invalid_argument in the same cases as `judge`, or if the two states of a surface
/// have different numbers of vertices, or `one` has another length.
PathVerdict judge_path(const TriangleMesh& mesh_t0, std::span<const Vec3> mesh_t1,
                       const TriangleMesh& body_t0, std::span<const Vec3> body_t1,
                       std::span<const std::int32_t> one = {});

enum class PathKind {
  point_triangle,  ///< the point p, then the triangle's corners a, b, c
  edge_edge,       ///< the ends a0, a1 of the first edge, then b0, b1 of the second
};

/// True if and only if the two closed primitives have a common point at some time t in [0,1]. Every
/// vertex moves on a straight line: points 0 to 3 are its positions at the start, t = 0, and points
/// 4 to 7 those at the end, t = 1. Touching counts. All finite coordinates are valid, and so are
/// degenerate primitives and motions. Proven floating-point filters decide the easy cases, integers
/// of arbitrary length the rest. The function shares no code with the narrow phases and serves as
/// their oracle.
bool paths_touch(PathKind kind, std::span<const Vec3, 8> points);

/// Like paths_touch, but without the filters.
bool paths_touch_unfiltered(PathKind kind, std::span<const Vec3, 8> points);

/// Earliest time at which the primitives touch. It is an algebraic number, so it is enclosed: lo is
/// the largest double not above it, hi the smallest double not below it, and lo == hi if and only
/// if the time is a double. Integers decide the enclosure.
struct TouchTime {
  double lo, hi;
};

/// Empty if the primitives never touch.
std::optional<TouchTime> first_touch(PathKind kind, std::span<const Vec3, 8> points);

/// Like first_touch, but without the filters.
std::optional<TouchTime> first_touch_unfiltered(PathKind kind, std::span<const Vec3, 8> points);

}  // namespace selvedge
