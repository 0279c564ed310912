// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <cstdint>
#include <span>
#include <vector>

namespace selvedge {

/// Pose of a rigid body: x = rotation · X + translation.
struct Pose {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();  ///< metres
};

/// Promise that lets a broad phase reuse the tree of a moving rigid body: while two views carry the
/// same nonzero id, their edges and triangles are identical, and x_t0 and x_t1 are the poses t0 and
/// t1 of the same points X, computed in double precision.
struct RigidMotion {
  std::uint64_t id = 0;
  Pose t0, t1;
};

/// One surface over one time step. Vertex i moves on the straight line x_t0[i] -> x_t1[i], t in
/// [0,1]. This is a view: its creator keeps the arrays alive.
struct SurfaceView {
  std::span<const Vec3> x_t0, x_t1;     ///< metres, n each
  std::span<const Edge> edges;          ///< unique; contains every edge of every triangle once
  std::span<const Triangle> triangles;  ///< vertex indices, less than n
  /// Metres. A detector inflates the surface by this distance on its side; two inflated surfaces
  /// overlap if their distance is at most the sum of the two thicknesses.
  double thickness = 0.0;
  /// Promise that lets a broad phase reuse its tree: while two views carry the same nonzero id,
  /// their x_t0, x_t1, edges and triangles are identical. 0 promises nothing.
  std::uint64_t static_id = 0;
  /// Null promises nothing. Ignored if static_id is nonzero.
  const RigidMotion* rigid = nullptr;
};

/// A point of one surface against a triangle of another (or the same) surface.
struct PointTrianglePair {
  std::int32_t point, triangle;
  auto operator<=>(const PointTrianglePair&) const = default;
};

/// An edge of one surface against an edge of another (or the same) surface.
struct EdgeEdgePair {
  std::int32_t edge_a, edge_b;
  auto operator<=>(const EdgeEdgePair&) const = default;
};

/// Output of a broad phase: indices into the vertices, edges and triangles of its two input views.
/// Lists are sorted and free of duplicates. For a surface against itself, pairs whose primitives
/// share a vertex are omitted, edge_a < edge_b, and triangle_point is empty.
struct CandidatePairs {
  std::vector<PointTrianglePair> point_triangle;  ///< point of a, triangle of b
  std::vector<PointTrianglePair> triangle_point;  ///< triangle of a, point of b
  std::vector<EdgeEdgePair> edge_edge;            ///< edge of a, edge of b

  void clear() {
    point_triangle.clear();
    triangle_point.clear();
    edge_edge.clear();
  }
  std::size_t size() const {
    return point_triangle.size() + triangle_point.size() + edge_edge.size();
  }
};

/// Which primitives touch, and in which order Contact::vertex lists them.
enum class ContactKind : std::uint8_t {
  point_triangle,  ///< vertices: point of a, then the three corners of b's triangle
  triangle_point,  ///< vertices: point of b, then the three corners of a's triangle
  edge_edge,       ///< vertices: two of a's edge, then two of b's edge
};

/// Two primitives that touch during the step (a collision) or are near at its start (a proximity).
/// The signed sum of weight[k] * x[vertex[k]] is the vector from the contact point on the second
/// primitive to the contact point on the first. The weights are (1, -u, -v, -w) for a point and a
/// triangle and (1-s, s, -(1-t), -t) for two edges. The dot product of this vector with `normal` is
/// the gap, positive at t = 0.
struct Contact {
  ContactKind kind;
  std::array<std::int32_t, 4> vertex;  ///< indices into a or b, as `kind` says
  std::array<double, 4> weight;        ///< signed barycentric weights, sum 0
  Vec3 normal;                         ///< unit, from the second primitive towards the first
  double toi = 0.0;                    ///< time of impact in [0,1]; never later than the exact one
  double gap = 0.0;                    ///< metres between the primitives at t = 0
};

/// What a detector guarantees about missed pairs.
enum class Guarantee : std::uint8_t {
  conservative,  ///< misses nothing
  approximate,   ///< may miss pairs; the detector's header says which
};

}  // namespace selvedge
